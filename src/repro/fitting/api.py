"""`identify`: check what was given, read, fit, assemble. The command line calls the same."""

import logging
import tempfile
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import NoneType

import pandas as pd

from repro.board.capture import files_of
from repro.errors import InputError, check_kind, failure, require
from repro.fitting.earlier import changes_since
from repro.fitting.evaluate import add_runs, add_self_test, assemble, fit_all, resolve
from repro.fitting.identification import Identification
from repro.fitting.prepare import LoadedLog, Options, load_log
from repro.fitting.prior import read_prior, with_plane
from repro.fitting.problem import IdentificationProblem, make_problem
from repro.fitting.result import Curves, Result
from repro.fitting.text import summary
from repro.identification.armfile import Arm, read_arm
from repro.identification.log import Log
from repro.identification.method import GROUPS, NETWORKS, network_cache
from repro.logs.load import Source
from repro.progress import Progress

_LOG = logging.getLogger(__name__)

Recording = str | Path | pd.DataFrame | Log


def identify(
    log: Recording | Sequence[Recording],
    *,
    validate: Recording | Sequence[Recording] = (),
    arm: str | Path | Arm | None = None,
    method: str | Sequence[str] = "weighted-consistent",
    filter: str = "dct",
    cutoff: float | None = None,
    friction: bool = True,
    prior: str | Path | Mapping[str, Mapping[str, float]] | None = None,
    earlier: str | Path | None = None,
    self_test: bool = False,
    seed: int = 1,
    steps: int = 1500,
    cache: str | Path | None = None,
) -> Identification:
    """Estimate the nine parameters of Eq. 1, tau = Y beta, of an arm from what it recorded.

    The numbers are those of ``repro identify`` with the same options. Progress is logged at level INFO.

    Parameters
    ----------
    log : path, DataFrame, Log, or sequence of these
        Recording to fit. Several recordings of one arm make one fit.
    validate : path, DataFrame, Log, or sequence of these
        Recordings that only judge the result.
    arm : path or Arm, optional
        Conventions of the arm: columns, units, signs, zero positions, torque constants.
    method : str or sequence of str
        ``"ordinary"``, ``"weighted"``, ``"robust"``, ``"instrumental"``, ``"bounded"``, ``"consistent"``,
        ``"weighted-consistent"``, ``"parsimonious"``, ``"algorithm1"``, ``"algorithm1+refinement"``, or the groups
        ``"least-squares"`` and ``"all"``. Of several methods the one that predicts best is recommended.
    filter : {"dct", "savitzky-golay", "butterworth"}
        Zero-phase filter.
    cutoff : float, optional
        Its cut-off, Hz; chosen from the recording by default.
    friction : bool
        Whether to subtract friction that Eq. 1 does not model, where the recording shows it.
    prior : path or mapping, optional
        What is known before: ``parameters.json`` of an earlier result, whose intervals count, or
        ``{"g1": {"value": 1.0, "sd": 0.1}}``, in a file or as a mapping. A standard deviation of 0 keeps the value.
    earlier : path, optional
        ``parameters.json`` of an earlier result, with which the parameters are compared.
    self_test : bool
        Whether to estimate known parameters from synthetic recordings of the same motion.
    seed : int
        Of standard errors, training and search.
    steps : int
        Training steps of the CNN.
    cache : path, optional
        Folder of trained networks; that of the command by default.

    Returns
    -------
    Identification
        Parameters with intervals, errors, residuals.

    Warns
    -----
    UserWarning
        Of each thing in the recordings that can make the result wrong, as in ``result.warnings``.

    Raises
    ------
    InputError
        If a recording, the arm or an option is not valid, in one line.

    Examples
    --------
    The simulated board's recording of Eq. 10, judged on another motion:

    >>> import repro
    >>> result = repro.identify("data/captures/ID.bin", validate="data/captures/T2.bin", method="bounded")
    >>> result.parameters.loc["g1", "verdict"]
    'known to 31 %'
    >>> result.parameters["estimate"].round(2).to_dict()
    {'I1': 0.1, 'I2': 0.01, 'I3': 0.03, 'g1': 0.41, 'g2': 0.1, 'b1': 0.09, 'b2': 0.03, 'k1': 0.45, 'k2': 0.33}
    >>> unseen = result.errors[result.errors["part"] == "validation"]
    >>> unseen["relative_rms"].round(2).to_list()
    [0.18, 0.2]
    >>> result.residuals.columns.to_list()
    ['log', 'time_s', 'joint', 'torque_nm', 'rebuilt_nm', 'residual_nm']
    >>> len(result.warnings) > 0
    True
    >>> figure = result.plot()
    """
    fitted, validation = _several("log", log), _several("validate", validate)
    check_kind("arm", arm, (str, Path, Arm, NoneType), "a path or an Arm")
    for name, path in (("cache", cache), ("earlier", earlier)):
        check_kind(name, path, (str, Path, NoneType), "a path")
    for name, switch in (("friction", friction), ("self_test", self_test)):
        check_kind(name, switch, bool, "True or False")
    described = arm if isinstance(arm, Arm) else read_arm(arm)
    names = choose_methods(method, len(fitted), self_test)
    before = None if prior is None else read_prior(prior)
    networks = _expanded(Path(cache or network_cache()))
    options = Options(names, networks, filter, cutoff, seed, steps, before, friction)
    if set(names) & set(NETWORKS):
        if with_plane(before, described) is not None:
            given = "prior" if before is not None else f"{described.file}: plane"
            raise InputError.at(given, "given for Algorithm 1", "method least-squares, or one of its methods")
        require("torch", "cnn", "method Algorithm 1", "method least-squares, or ")
        _check_cache(options.cache)
    loaded = [load_log(source, described) for source in (*fitted, *validation)]
    for k, loaded_log in enumerate(loaded):
        _report_log(loaded_log, briefly=k > 0)
    problem = make_problem(loaded[: len(fitted)], loaded[len(fitted) :], described, options)
    for prepared in problem.logs:
        s = prepared.settings
        _LOG.info("%s: cut-off %.3g Hz: %s", prepared.loaded.name, s.cutoff, prepared.cutoff.reason)
        delay = f"{1e3 * abs(s.delay):.3g} ms {'earlier' if s.delay < 0.0 else 'later'}"
        _LOG.info("the torque acts %s than recorded; lambda %.4g s/rad", delay, s.friction_steepness)
    result, curves = _solve(problem, described, options, self_test)
    if earlier is not None:
        result = replace(result, changes=changes_since(Path(earlier), result))
    for line in result.all_warnings:
        warnings.warn(line, stacklevel=2)
    inputs = [Path(source) for source in (*fitted, *validation, arm, prior, earlier) if isinstance(source, (str, Path))]
    captures = [file for path in inputs if path.suffix == ".bin" for file in files_of(path)]
    return Identification(result, result.recommended, curves, described, (*inputs, *captures), problem.first.load)


def _solve(problem: IdentificationProblem, arm: Arm, options: Options, self_test: bool) -> tuple[Result, Curves]:
    """Run the methods, those that take seconds first."""
    bars: dict[str, Progress] = {}

    def progress(what: str, done: int, total: int, note: str = "") -> None:
        bars.setdefault(what, Progress(what))(done, total, note)

    methods = resolve(options, progress)
    quick = [m for m in methods if m.name not in NETWORKS]
    fits = fit_all(problem, quick, options.seed, progress)
    if fits and len(quick) < len(methods):
        _LOG.info("so far, without the CNN:\n%s", summary(assemble(problem, fits, arm)[0]))
    fits += fit_all(problem, [m for m in methods if m not in quick], options.seed, progress)
    if not fits:
        raise InputError.at(problem.first.loaded.name, "no solution by any method", "a log that shows more, see above")
    result, curves = assemble(problem, fits, arm)
    if len(problem.logs) > 1:
        result = add_runs(result, problem, methods, options.seed, progress)
    return (add_self_test(result, problem, arm, options, progress) if self_test else result), curves


def _several(name: str, given: Recording | Sequence[Recording]) -> tuple[Source, ...]:
    """Give one or several recordings as a tuple, names of files as paths."""
    recordings = tuple(given) if isinstance(given, (list, tuple)) else (given,)
    expected = "a path, a DataFrame, Log(t=..., q=..., tau=...) of arrays, or a list of these"
    for recording in recordings:
        check_kind(name, recording, (str, Path, pd.DataFrame, Log), expected)
    return tuple(Path(recording) if isinstance(recording, str) else recording for recording in recordings)


def choose_methods(method: str | Sequence[str], n_logs: int = 1, self_test: bool = False) -> tuple[str, ...]:
    """Resolve groups of methods; several logs are for least squares, because a network is trained for one motion."""
    if not n_logs:
        raise InputError.at("log", "no recording", "at least one")
    given = tuple(method) if isinstance(method, (list, tuple)) else (method,)
    for choice in given:
        check_kind("method", choice, str, "a name or a list of names")
    names = tuple(dict.fromkeys(name for choice in given for name in GROUPS.get(choice, (choice,))))
    unknown = [name for name in names if name not in GROUPS["all"]]
    if unknown or not names:
        known = ", ".join((*GROUPS, *GROUPS["all"]))
        raise InputError.at("method", repr(unknown[0]) if unknown else "none", f"one of {known}")
    if n_logs > 1 and set(names) & set(NETWORKS):
        expected = "method least-squares, or one log: a network is trained for one motion"
        raise InputError.at("method", "Algorithm 1 for several logs", expected)
    if self_test and not set(names) - set(NETWORKS):
        raise InputError.at("self_test", "Algorithm 1 alone", "a method of least squares, which claims intervals")
    return names


def _expanded(cache: Path) -> Path:
    try:
        return cache.expanduser()
    except RuntimeError as error:
        raise InputError.at(f"cache: {cache}", "no such user", "a folder that can be written") from error


def _check_cache(cache: Path) -> None:
    """Refuse a cache that cannot be written before minutes of training are spent."""
    try:
        cache.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=cache):
            pass
    except OSError as error:
        raise InputError.at(f"cache: {cache}", failure(error), "a folder that can be written") from error


def _report_log(loaded: LoadedLog, briefly: bool) -> None:
    d = loaded.description
    _LOG.info("%s%s", d.name, " (simulated board)" if d.simulated else "")
    for label, value in d.facts:
        if not briefly or label in ("length", "rate", "gaps"):
            _LOG.info("  %s: %s", label, value)
    for note in d.notes:
        _LOG.info("  note: %s", note)
    for warning in d.warnings:
        _LOG.info("  WARNING: %s", warning)
