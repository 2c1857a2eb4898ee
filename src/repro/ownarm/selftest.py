"""Known parameters on the user's own motion: what comes out where Eq. 1 is right, beside what came out of the log.

The estimate is taken for the truth and the smoothed motion for what the arm did. Eq. 1 gives the torque; noise, steps
of encoders and torque, time stamps, delay and faults of the set-up are put back as they were found. The log made so is
prepared and solved as the real one was, with the cut-off and lambda of that. Noise is white: of the position as strong
as in the upper half of its spectrum, of the torque as just above the frequencies that the motion is looked at.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import welch

from repro.identification.bootstrap import bootstrap
from repro.identification.extra_terms import correct_calibration, values_of
from repro.identification.filtering import SEGMENT, motion_cutoff, smooth_motion
from repro.identification.method import Method
from repro.identification.regression import joined
from repro.identification.scores import relative_rms
from repro.logs.armfile import Arm
from repro.logs.diagnostics import quantisation_step
from repro.logs.log import Log, period
from repro.logs.uniform import segments, uniform
from repro.model.dynamics import regressor
from repro.model.parameters import NAMES, Array
from repro.ownarm.prepared import Problem, Ready, Told, make_ready, together
from repro.ownarm.settings import Options
from repro.streams import Stream, stream

DRAWS = 5
#: Share of the squared torque error that noise makes, below which Eq. 1 is said to be wrong.
NOISE = 0.5


@dataclass(frozen=True)
class Returned:
    """One parameter: the truth, what came out of the draws, and how many of the intervals claimed hold the truth."""

    name: str
    true: float
    median: float
    low: float
    high: float
    hold: int
    intervals: int


@dataclass(frozen=True)
class SelfTest:
    """What a method makes of logs with the parameters that it found.

    Attributes
    ----------
    method : str
        Its name.
    draws : int
        How many logs were made.
    parameters : tuple of Returned
        The nine.
    error, real : tuple of 2 floats
        Relative RMS torque error of each joint, fractions of 1: median of the draws, and of the log itself.
    noise : tuple of 2 floats
        Share of the squared `real` that noise makes, at most 1.
    model_wrong : bool
        Whether that is less than half, of either joint.
    """

    method: str
    draws: int
    parameters: tuple[Returned, ...]
    error: tuple[float, float]
    real: tuple[float, float]
    noise: tuple[float, float]
    model_wrong: bool

    @property
    def rows(self) -> list[tuple[str, ...]]:
        """The table in print: parameter, truth, median, range, intervals that hold the truth."""
        return [
            (
                p.name,
                f"{p.true:.4g}",
                f"{p.median:.4g}",
                f"{p.low:.4g} to {p.high:.4g}",
                f"{p.hold} of {p.intervals}" if p.intervals else "none claimed",
            )
            for p in self.parameters
        ]

    @property
    def verdict(self) -> str:
        """What the errors say, in one line."""
        right, here = ("/".join(f"{100.0 * x:.1f}" for x in pair) for pair in (self.error, self.real))
        noise = "/".join(f"{100.0 * x:.0f}" for x in self.noise)
        told = f"if Eq. 1 were right, the torque error of joint 1/2 would be {right} %; it is {here} %"
        if self.model_wrong:
            return f"{told}: noise makes {noise} % of its square, the rest is the model: friction, flexibility, set-up"
        return f"{told}: about what noise makes, and no sign that Eq. 1 is wrong"


def _level(x: Array, h: float, low: float, high: float) -> Array:
    """Standard deviation of white noise as strong as a signal is between two frequencies, shape (2, 1)."""
    segment = min(round(SEGMENT / h), x.shape[-1] // 4)
    frequency, density = welch(x, 1.0 / h, window="blackmanharris", nperseg=segment, axis=-1)
    band = (frequency >= low) & (frequency <= high)
    level: Array = np.sqrt(0.5 / h * np.median(density[:, band], axis=-1, keepdims=True))
    return level


def _written(signal: Array, recorded: Array, noise: Array, rng: np.random.Generator) -> Array:
    """A signal with noise and rounded as the recorded one was; what rounding makes of the noise is not added twice."""
    rounded = []
    for x, there, size in zip(signal, recorded, noise[:, 0], strict=True):
        step = quantisation_step(there)
        drawn = x + np.sqrt(max(size**2 - (step or 0.0) ** 2 / 12.0, 0.0)) * rng.normal(size=x.shape)
        rounded.append(step * np.rint(drawn / step) if step else drawn)
    return np.stack(rounded)


def _undone(found: Mapping[str, float]) -> dict[str, float]:
    """Faults that put those found back."""
    scale = found.get("scale2", 1.0)
    factor = {"offset2": 1.0 / scale}
    return {name: 1.0 / value if name == "scale2" else -factor.get(name, 1.0) * value for name, value in found.items()}


def _from_zero(log: Log) -> Log:
    return replace(log, t=log.t - log.t[0])


def made_log(ready: Ready, beta: Array, rng: np.random.Generator) -> Told:
    """The log, or its longest piece, as it would have been recorded of an arm with known parameters."""
    s, log = ready.settings, _from_zero(ready.told.log.longest)
    pieces = segments(ready.told.recorded or ready.told.log)[0]
    piece = _from_zero(max(pieces, key=lambda one: one.t.size))
    even, h, top = uniform(piece), period(log), motion_cutoff(s, period(log))
    moved = smooth_motion(log.q, h, s)
    acting = CubicSpline(log.t, regressor(*moved, s.friction_steepness) @ beta, axis=1)
    late = acting(np.clip(log.t + s.delay, 0.0, log.t[-1]))
    right = correct_calibration(replace(log, q=moved[0], tau=late), _undone(values_of(ready.faults)))
    # Above the motion's frequencies the torque holds friction, and what Eq. 1 leaves of it noise of the position.
    noise = [_level(x, h, top, 2.0 * top) for x in (even.tau, even.tau - right.tau)]
    # Stamps that were taken for rounded say when a sample was written; it was taken at the even instant.
    at = even.t if even.t.size == piece.t.size and np.array_equal(even.q, piece.q) else piece.t
    q, tau = (CubicSpline(even.t, x, axis=1)(np.clip(at, 0.0, even.t[-1])) for x in (right.q, right.tau))
    made = replace(
        piece,
        q=_written(q, piece.q, _level(even.q, h, 0.25 / h, np.inf), rng),
        tau=_written(tau, piece.tau, np.minimum(*noise), rng),
        dq=None,
    )
    return Told(uniform(made), ready.told.description, made)


def self_test(
    problem: Problem,
    method: Method,
    beta: Array,
    arm: Arm,
    options: Options,
    report: Callable[[str, int, int, str], None],
    draws: int = DRAWS,
) -> SelfTest:
    """Make logs with the parameters that a method found, and solve them by that method as the real ones were."""
    betas, inside, claimed, errors = [], [], [], []
    for draw in range(draws):
        rng = stream(options.seed, Stream.SELF_TEST, draw)
        logs = tuple(_again(log, beta, arm, options, rng) for log in problem.logs)
        moving, as_good = together(logs)
        found = method.estimate(moving)
        spread = bootstrap(method, moving, found, as_good, rng)
        betas.append(found.beta)
        claimed.append(found.beta != 0.0)
        inside.append((spread.low <= beta) & (beta <= spread.high) & claimed[-1])
        errors.append(relative_rms(joined([log.regression for log in logs]), found.beta))
        report("self-test", draw + 1, draws, "")
    real = relative_rms(problem.regression, beta)
    error = np.median(errors, axis=0)
    noise = np.minimum(np.divide(error, real, out=np.ones(2), where=np.array(real) > 0.0) ** 2, 1.0)
    columns = (beta, np.median(betas, 0), np.min(betas, 0), np.max(betas, 0), np.sum(inside, 0), np.sum(claimed, 0))
    rows = zip(NAMES, *(column.tolist() for column in columns), strict=True)
    parameters = tuple(Returned(*row) for row in rows)
    return SelfTest(
        method.name,
        draws,
        parameters,
        (float(error[0]), float(error[1])),
        real,
        (float(noise[0]), float(noise[1])),
        bool(noise.min() < NOISE),
    )


def _again(log: Ready, beta: Array, arm: Arm, options: Options, rng: np.random.Generator) -> Ready:
    """A made log prepared as the real one was."""
    same = replace(arm, friction_steepness=log.settings.friction_steepness)
    return make_ready(made_log(log, beta, rng), same, replace(options, cutoff=log.settings.cutoff, friction=False))
