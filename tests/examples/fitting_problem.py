"""Problems, judgements and whole runs of `repro identify` on a known arm, for the tests of `repro.fitting`."""

from dataclasses import replace

import numpy as np
from log_example import BETA, columns, log_of, motion, recording, text
from regression_example import H, exact, other_motion

from repro.fitting.evaluate import assemble, evaluate, fit, fit_all, resolve
from repro.fitting.prepare import LoadedLog, Options, PreparedLog, load_log
from repro.fitting.problem import IdentificationProblem, make_problem
from repro.identification.armfile import Arm
from repro.identification.excitation import excitation
from repro.identification.filtering import Cutoff, FilterSettings
from repro.identification.least_squares import METHODS
from repro.logs.diagnostics import Description
from repro.model.dynamics import inverse_dynamics

ARM = Arm(name="test arm")
OPTIONS = Options(("ordinary",), "unused")
FILES = ["arm.urdf", "arm.xml", "methods.bib", "parameters.csv", "parameters.json"]
FILES += ["provenance.json", "report.html", "residuals.csv", "scores.csv"]


def silent(*_):
    """A progress that nobody sees."""


def loaded(log):
    return LoadedLog(log, Description(log.name, (("samples", str(log.t.size)),)))


def problem_of(regression, validation=(), without_standstill=None, estimates_delay=True, **settings):
    """A problem around a regression that no filter made; the arm always moves unless `without_standstill` is given."""
    rows = regression if without_standstill is None else without_standstill
    excited = excitation(rows)
    made_up = Cutoff(5.0, "made up", np.zeros(0), np.zeros((2, 0)), np.zeros((2, 0)), 10.0)
    log = loaded(log_of(recording(np.arange(0.0, 20.0, 0.005))))
    prepared = PreparedLog(log, log.log, regression, FilterSettings(**settings), made_up, delay_error=0.0)
    return IdentificationProblem((prepared,), regression, rows, {}, tuple(validation), excited, estimates_delay)


def problem_of_logs(*logs, validation=(), arm=ARM, **options):
    """The problem of loaded logs, with ordinary least squares unless the options say otherwise."""
    return make_problem(logs, validation, arm, replace(OPTIONS, **options))


def noisy(beta, seed=0, size=0.02, n=1200):
    noise = size * np.random.default_rng(seed).normal(size=(2, n))
    return exact(motion(H * np.arange(n)), beta, noise)


def judged(problem):
    """What ordinary least squares finds, without halves and positions."""
    return evaluate(fit(METHODS["ordinary"], problem, 1, False, silent), problem, (None,))


def write_log(path, moved=motion, seconds=12.0, rate=200.0, beta=BETA, steepness=20.0, late=0.0):
    """A recording of the arm as a CSV file; the torque is recorded so much before it acts."""
    t = np.arange(round(seconds * rate)) / rate
    q, dq, _ = moved(t)
    tau = inverse_dynamics(*moved(t + late), beta, steepness)
    r = recording(t)
    path.write_text(text(columns(replace(r, q=q, dq=dq, tau=tau))), encoding="utf-8")
    return path


def prepared_from_file(folder, arm=ARM, **log):
    loaded_log = load_log(write_log(folder / "log.csv", **log), arm)
    return problem_of_logs(loaded_log, arm=arm, methods=tuple(METHODS), cache=folder)


def identify(folder, methods=tuple(METHODS), **log):
    """All of `repro identify` but its files: problem, result and curves."""
    options = Options(methods, folder / "cache")
    fitted = load_log(write_log(folder / "log.csv", **log), ARM)
    validation = load_log(write_log(folder / "other.csv", other_motion, 8.0), ARM)
    problem = make_problem((fitted,), (validation,), ARM, options)
    found = fit_all(problem, resolve(options, silent), options.seed, silent)
    return (problem, *assemble(problem, found, ARM))


def solved(problem, methods=("ordinary",), arm=ARM):
    """Result and curves of some methods of least squares."""
    return assemble(problem, fit_all(problem, [METHODS[name] for name in methods], 1, silent), arm)


def tree(folder):
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}
