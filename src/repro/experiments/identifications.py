"""Identifications of the numeric arms (Section V-B) and of recordings (V-C), their scores, and both read from files."""

import logging
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from repro.cnn.dataset import DataSettings
from repro.cnn.priors import sample_beta
from repro.config.model import Configuration
from repro.config.sections import data_settings
from repro.documents import read_json
from repro.errors import InputError
from repro.experiments.arm import Recording, read_recordings, true_parameters
from repro.files import read_csv
from repro.identification.algorithm1.preprocessing import PreparedSignals, derivatives, filtered, prepare
from repro.identification.algorithm1.search import ImageMotion
from repro.identification.least_squares import METHODS
from repro.identification.method import BASELINES, as_json
from repro.identification.regression import Regression
from repro.identification.scores import score
from repro.model.dynamics import inverse_dynamics, rebuild_torque, regressor
from repro.model.parameters import NAMES, Array
from repro.progress import over
from repro.signals.dct import SignalSettings
from repro.signals.metric import MetricSettings, metr2ev
from repro.signals.trajectories import Motion, identification_trajectory, random_trajectory, sample_times
from repro.streams import Stream, stream

if TYPE_CHECKING:
    from repro.identification.algorithm1.refinement import Algorithm1

_LOG = logging.getLogger(__name__)

#: The one case of the experiment's identifications: parameters come from this motion.
CASE = "ID"
#: Columns of the scores of the arm, and of the numeric arms.
SCORES = ("case", "method", "seed", "joint", "time", "frequency", "total")
NUMERIC_SCORES = ("case", "method", "seed", "trajectory", "joint", "time", "frequency", "total")


def mean_training_torque(signals: SignalSettings, data: DataSettings, seed: int) -> Array:
    """Mean torque of the training data along the identification trajectory (centre of Fig. 9)."""
    motion = identification_trajectory(signals.duration_s, signals.sampling_period_s)
    beta = sample_beta(stream(seed, Stream.TRAINING_ARMS), 10_000, data.prior).mean(0)
    return inverse_dynamics(motion.q, motion.dq, motion.ddq, beta)


def mean_torque(config: Configuration) -> pd.DataFrame:
    """Mean training torque, which fit2trt needs, over time."""
    signals = config.signals
    joint1, joint2 = mean_training_torque(signals, data_settings(config), config.training.seed)
    return pd.DataFrame(
        {"time": sample_times(signals.duration_s, signals.sampling_period_s), "joint1": joint1, "joint2": joint2}
    )


def read_mean_torque(path: Path, signals: SignalSettings) -> Array:
    """Mean training torque of a file, an array of shape (2, N), checked for length and finite numbers."""
    columns, samples = ("joint1", "joint2"), sample_times(signals.duration_s, signals.sampling_period_s).size
    table = read_csv(path, columns)[list(columns)].apply(pd.to_numeric, errors="coerce")
    if len(table) != samples:
        raise InputError.at(f"{path}: rows", len(table), f"{samples}, one for each sample of the trajectory")
    wrong = ~np.isfinite(table.to_numpy())
    if wrong.any():
        line, column = np.argwhere(wrong)[0]
        raise InputError.at(f"{path}: line {line + 2}: {columns[column]}", "no finite number", "a torque in N m")
    return np.asarray(table.to_numpy(dtype=np.float64).T)


def motion_of(trajectory: str, config: Configuration, seed: int) -> Motion:
    """Motion that estimates are scored on: ``ID`` (Eq. 10) or ``validation``, the random one of a seed (Fig. 16)."""
    signals = config.signals
    if trajectory == "ID":
        return identification_trajectory(signals.duration_s, signals.sampling_period_s)
    rng, duration = stream(seed, Stream.VALIDATION), config.numeric.validation_samples * signals.sampling_period_s
    return random_trajectory(
        rng, duration, signals.sampling_period_s, signals.filter_coefficient, "index"
    )  # Table 7 requires it


def _arms(config: Configuration) -> Iterator[tuple[str, Array, Regression]]:
    """Every test arm, with its torque and motion on the identification trajectory, cut out of the recorded margin."""
    signals, margin = config.signals, config.numeric.margin_samples
    samples = sample_times(signals.duration_s, signals.sampling_period_s).size
    recorded = identification_trajectory(signals.duration_s, signals.sampling_period_s, margin)
    y = regressor(recorded.q, recorded.dq, recorded.ddq)
    for name, parameters in config.numeric.arms:
        beta = np.array(parameters)
        yield name, beta, filtered(recorded.q, rebuild_torque(y, beta), signals, margin, margin + samples)


def identify_arms(algorithm1: "Algorithm1", config: Configuration, tau_mean: Array, seed: int) -> dict[str, Any]:
    """Identify every test arm by Algorithm 1, its refinement and the controls, with the mean training torque (2, N)."""
    arms: dict[str, Any] = {}
    for index, (name, beta, measured) in enumerate(over([*_arms(config)], f"{algorithm1.variant} image, seed {seed}")):
        streams = (stream(seed, kind, index) for kind in (Stream.SEARCH, Stream.REFINE, Stream.UNIFORM_SEARCH))
        found, met = algorithm1.run(prepare(measured, tau_mean, config.signals), *streams)
        arms[name] = _arm(beta, as_json(found), executions_over_threshold=met)
        _LOG.info("%s: %d of %d executions over the threshold", name, met, algorithm1.search.executions)
    return {"variant": algorithm1.variant, "seed": seed, "arms": arms}


def least_squares_of_arms(config: Configuration) -> dict[str, Any]:
    """Identify every test arm by least squares on the signals of Algorithm 1; N2 and N3 have no definite inertia."""
    arms = {name: _arm(beta, _least_squares(r, ("least-squares", "bounded"))) for name, beta, r in _arms(config)}
    return {"variant": "least-squares", "seed": 0, "arms": arms}


def _arm(true: Array, methods: Mapping[str, Any], **notes: int) -> dict[str, Any]:
    return {"true": true.tolist(), **notes, "methods": methods}


def _least_squares(regression: Regression, methods: Iterable[str]) -> dict[str, Any]:
    """Estimates by methods that a user's own arm is identified by."""
    return as_json({name: METHODS[BASELINES[name]].estimate(regression) for name in methods})


def score_estimates(runs: Sequence[Mapping[str, Any]], config: Configuration, metric: MetricSettings) -> pd.DataFrame:
    """Similarity of the numeric torques and their rebuilding, for every seed."""
    frames = []
    for run in runs:
        for trajectory in ("ID", "validation"):
            motion = motion_of(trajectory, config, run["seed"])
            y = regressor(motion.q, motion.dq, motion.ddq)
            for case, arm in run["arms"].items():
                of_arm = score(y, rebuild_torque(y, np.array(arm["true"])), arm["methods"], metric)
                frames.append(of_arm.assign(case=case, seed=run["seed"], trajectory=trajectory))
    return pd.concat(frames, ignore_index=True)[list(NUMERIC_SCORES)]


def score_numeric(identifications: Sequence[Path], config: Configuration) -> pd.DataFrame:
    """Similarity of every estimate of the numeric arms, on the identification and the validation trajectories."""
    return score_estimates(read_identifications(identifications), config, config.metric)


def prepare_recording(
    recording: Recording, tau_mean: Array | None, signals: SignalSettings, image_motion: ImageMotion = "measured"
) -> PreparedSignals:
    """Lines 1 to 12 of Algorithm 1 for a recording of any duration; the level of line 5 cancels in line 32."""
    n1, n2, regression = recording.program.n1, recording.program.n2, recording.regression(signals)
    tau_mean = regression.tau if tau_mean is None else tau_mean
    n, m = n2 - n1, tau_mean.shape[1]
    phase = (np.arange(n) + 0.5) * m / n - 0.5
    mean = np.stack([np.interp(phase, np.arange(m), joint) for joint in tau_mean])
    shown = None
    if image_motion == "desired":
        q, dq, ddq = (x[:, n1:n2] for x in derivatives(recording.program.q, signals))
        shown = q, dq, ddq
    return prepare(regression, mean, signals, m / n, shown)


def identify_recording(
    algorithm1: "Algorithm1", recording: Recording, tau_mean: Array, signals: SignalSettings, seed: int, true: Array
) -> dict[str, Any]:
    """Identify one recording by Algorithm 1, by its refinement, and by the refinement's controls."""
    prepared = prepare_recording(recording, tau_mean, signals, algorithm1.search.image_motion)
    kinds = (Stream.EXPERIMENT_SEARCH, Stream.EXPERIMENT_REFINE, Stream.UNIFORM_SEARCH)
    found, met = algorithm1.run(prepared, *(stream(seed, kind) for kind in kinds))
    arm = _arm(true, as_json(found), executions_over_threshold=met)
    return {"variant": algorithm1.variant, "seed": seed, "arms": {CASE: arm}}


def least_squares_of(recording: Recording, signals: SignalSettings, true: Array, seed: int = 0) -> dict[str, Any]:
    """What Algorithm 1 is compared with, and the parameters that the arm has."""
    methods = _least_squares(recording.regression(signals), BASELINES) | {"true": {"beta": true.tolist()}}
    return {"variant": "least-squares", "seed": seed, "arms": {CASE: _arm(true, methods)}}


def identify_least_squares(captures: Sequence[Path], config: Configuration) -> dict[str, Any]:
    """The arm's parameters by least squares, plain and with constraints."""
    (recording,) = read_recordings(captures, config)
    return least_squares_of(recording, config.signals, true_parameters(config))


def score_runs(
    runs: Sequence[Mapping[str, Any]], recordings: Sequence[Recording], signals: SignalSettings, metric: MetricSettings
) -> pd.DataFrame:
    """Similarity of measured and rebuilt torque for every run and motion."""
    frames = []
    for recording in recordings:
        r = recording.regression(signals)
        for run in runs:
            scores = score(r.y, r.tau, run["arms"][CASE]["methods"], metric)
            frames.append(scores.assign(case=recording.program.name, seed=run["seed"]))
    return pd.concat(frames, ignore_index=True)[list(SCORES)]


def score_experiment(identifications: Sequence[Path], captures: Sequence[Path], config: Configuration) -> pd.DataFrame:
    """Similarity of every estimate of the arm on all five motions."""
    runs, recordings = read_identifications(identifications), read_recordings(captures, config)
    return score_runs(runs, recordings, config.signals, config.metric)


def tracking(recording: Recording, metric: MetricSettings) -> pd.DataFrame:
    """How well the arm followed the identification trajectory (Table 8), in the columns of `score_runs`."""
    proper = slice(recording.program.n1, recording.program.n2)
    s = metr2ev(recording.program.q[:, proper], recording.q[:, proper], metric)
    rows = [("tracking", "pd", 0, j + 1, s.time[j], s.frequency[j], s.total[j]) for j in (0, 1)]
    return pd.DataFrame(rows, columns=list(SCORES))


def _entries(place: str, value: object, what: str) -> dict[str, dict[str, Any]]:
    """Check that a JSON value is an object with entries, and replace each entry of another type by an empty object."""
    if not isinstance(value, dict) or not value:
        raise InputError.at(place, f"no {what}", "at least one")
    return {name: entry if isinstance(entry, dict) else {} for name, entry in value.items()}


def _check_nine(place: str, value: object) -> None:
    """Refuse a JSON value that is not a list of nine numbers."""
    if not isinstance(value, list) or len(value) != len(NAMES) or not all(isinstance(x, int | float) for x in value):
        raise InputError.at(place, "no parameter set", "nine numbers")


def every_seed(runs: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Runs with those that have no seed of their own (seed 0 of variant least-squares) repeated for each seed."""
    seeded = [dict(run) for run in runs if run["variant"] != "least-squares"]
    seeds = sorted({run["seed"] for run in seeded}) or [0]
    return seeded + [{**run, "seed": seed} for run in runs if run["variant"] == "least-squares" for seed in seeds]


def read_identifications(paths: Sequence[Path]) -> list[dict[str, Any]]:
    """Identifications of `every_seed`, checked for what later stages need."""
    runs = []
    for path in paths:
        run = read_json(path)
        if not isinstance(run, dict) or not {"seed", "variant", "arms"} <= run.keys():
            raise InputError.at(str(path), "no identification result", "fields seed, variant, arms")
        for case, arm in _entries(f"{path}: arms", run["arms"], "arm").items():
            place = f"{path}: arms.{case}"
            _check_nine(f"{place}.true", arm.get("true"))
            for method, estimate in _entries(f"{place}.methods", arm.get("methods"), "method").items():
                _check_nine(f"{place}.methods.{method}.beta", estimate.get("beta"))
        runs.append(run)
    return every_seed(runs)


def read_scores(paths: Sequence[Path], columns: tuple[str, ...] = NUMERIC_SCORES) -> pd.DataFrame:
    """Scores of one or more network variants in one table."""
    frames = [read_csv(path, columns) for path in paths]
    for path, frame in zip(paths, frames, strict=True):
        for column in ("time", "frequency", "total"):
            wrong = ~pd.to_numeric(frame[column], errors="coerce").between(0, 1)
            if wrong.any():
                row = int(wrong.to_numpy().argmax())
                raise InputError.at(f"{path}: line {row + 2}: {column}", frame[column][row], "a number from 0 to 1")
    return pd.concat(frames, ignore_index=True)
