"""Self-test: synthetic logs of the user's own motion with known parameters, solved as the real log was.

The estimate is the true parameter and the smoothed motion the motion of the arm; Eq. 1 gives the torque. Noise,
quantisation, time stamps, delay and calibration errors are added as estimated from the log. Noise is white: of the
position as strong as in the upper half of its spectrum, of the torque as just above the frequencies of the motion.
The synthetic log is prepared and solved as the real one, with its cut-off and lambda.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline

from repro.identification.calibration import correct_calibration
from repro.identification.extra_terms import values_of
from repro.identification.filtering import SEGMENT, motion_cutoff, smooth_motion
from repro.identification.method import Method
from repro.identification.regression import joined
from repro.identification.scores import relative_rms
from repro.identification.uncertainty import bootstrap
from repro.logs.armfile import Arm
from repro.logs.log import period, segments, uniform
from repro.logs.torque_limits import quantisation_step
from repro.model.dynamics import regressor
from repro.model.parameters import NAMES, Array
from repro.ownarm.prepare import LoadedLog, Options, PreparedLog, prepare_logs
from repro.ownarm.problem import IdentificationProblem, join_logs
from repro.ownarm.result import RecoveredParameter, SelfTest
from repro.streams import Stream, stream

DRAWS = 5
#: Share of the squared torque error that noise explains, below which Eq. 1 is wrong.
NOISE = 0.5


def _level(x: Array, h: float, low: float, high: float) -> Array:
    """Estimate the standard deviation (2, 1) of white noise as strong as a signal between two frequencies."""
    from scipy.signal import welch  # noqa: PLC0415  (a third of a second, for a self-test alone)

    segment = min(round(SEGMENT / h), x.shape[-1] // 4)
    frequency, density = welch(x, 1.0 / h, window="blackmanharris", nperseg=segment, axis=-1)
    band = (frequency >= low) & (frequency <= high)
    return np.asarray(np.sqrt(0.5 / h * np.median(density[:, band], axis=-1, keepdims=True)))


def _measured(signal: Array, recorded: Array, noise: Array, rng: np.random.Generator) -> Array:
    """Add noise to a signal and quantise it as the recorded one; quantisation noise is not added twice."""
    rounded = []
    for x, there, size in zip(signal, recorded, noise[:, 0], strict=True):
        step = quantisation_step(there)
        drawn = x + np.sqrt(max(size**2 - (step or 0.0) ** 2 / 12.0, 0.0)) * rng.normal(size=x.shape)
        rounded.append(step * np.rint(drawn / step) if step else drawn)
    return np.stack(rounded)


def inverse_errors(errors: Mapping[str, float]) -> dict[str, float]:
    """Give the corrections that add estimated calibration errors again."""
    scales = {name: 1.0 / value for name, value in errors.items() if name.startswith("scale")}
    factors = {f"offset{name[-1]}": factor for name, factor in scales.items()}
    return {name: -value * factors.get(name, 1.0) for name, value in errors.items()} | scales


def synthetic_log(prepared: PreparedLog, beta: Array, rng: np.random.Generator) -> LoadedLog:
    """Simulate the recording of a log, or of its longest piece, with an arm of known parameters."""
    s, pieces = prepared.settings, segments(prepared.loaded.recorded or prepared.loaded.log)
    longest = prepared.loaded.log.longest, max(pieces, key=lambda one: one.t.size)
    log, piece = (replace(one, t=one.t - one.t[0]) for one in longest)
    even, h, top = uniform(piece), period(log), motion_cutoff(s, period(log))
    moved = smooth_motion(log.q, h, s)
    acting = CubicSpline(log.t, regressor(*moved, s.friction_steepness) @ beta, axis=1)
    late = acting(np.clip(log.t + s.delay, 0.0, log.t[-1]))
    right = correct_calibration(replace(log, q=moved[0], tau=late), inverse_errors(values_of(prepared.faults)))
    # Above the frequencies of the motion the torque contains friction, and its residual the noise of the position.
    noise = [_level(x, h, top, 2.0 * top) for x in (even.tau, even.tau - right.tau)]
    # Rounded time stamps say when a sample was written; it was measured at the even instant.
    at = even.t if even.t.size == piece.t.size and np.array_equal(even.q, piece.q) else piece.t
    q, tau = (CubicSpline(even.t, x, axis=1)(np.clip(at, 0.0, even.t[-1])) for x in (right.q, right.tau))
    q = _measured(q, piece.q, _level(even.q, h, 0.25 / h, np.inf), rng)
    raw = replace(piece, q=q, tau=_measured(tau, piece.tau, np.minimum(*noise), rng), dq=None)
    return LoadedLog(uniform(raw), prepared.loaded.description, raw)


def self_test(
    problem: IdentificationProblem, method: Method, beta: Array, arm: Arm, options: Options, report: Callable[..., None]
) -> SelfTest:
    """Simulate logs with the parameters that a method estimated, and solve them by that method as the real ones."""
    betas, inside, claimed, errors = [], [], [], []
    for draw in range(DRAWS):
        rng = stream(options.seed, Stream.SELF_TEST, draw)
        logs: list[PreparedLog] = []
        for log in problem.logs:
            as_real = replace(options, cutoff=log.settings.cutoff, friction=False)
            arm = replace(arm, friction_steepness=log.settings.friction_steepness)
            logs += prepare_logs([synthetic_log(log, beta, rng)], arm, as_real)
        moving, as_good = join_logs(logs, problem.prior)
        estimate = method.estimate(moving)
        spread = bootstrap(method, moving, estimate, as_good, rng)
        betas.append(estimate.beta)
        claimed.append(estimate.beta != 0.0)
        inside.append((spread.low <= beta) & (beta <= spread.high) & claimed[-1])
        errors.append(relative_rms(joined([log.regression for log in logs]), estimate.beta))
        report("self-test", draw + 1, DRAWS)
    real, error = relative_rms(problem.regression, beta), np.median(errors, axis=0)
    noise = np.minimum(np.divide(error, real, out=np.ones(2), where=np.array(real) > 0.0) ** 2, 1.0)
    columns = (beta, np.median(betas, 0), np.min(betas, 0), np.max(betas, 0), np.sum(inside, 0), np.sum(claimed, 0))
    parameters = tuple(map(RecoveredParameter, NAMES, *(column.tolist() for column in columns)))
    wrong = bool(noise.min() < NOISE)
    return SelfTest(method.name, DRAWS, parameters, tuple(error.tolist()), real, tuple(noise.tolist()), wrong)
