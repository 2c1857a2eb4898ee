"""The printed numbers that an experiment must agree with, none of them of a network, and the rule of acceptance.

Misfit is the sum of squares of

- the Freq. factors of the ten cells of least squares (Table 10), in units of 1.5 points,
- log(1 - Time^2.5) of the same cells, in units of 0.5,
- what the mean-square torque has above the bound that the printed pairs of its cell permit, in units of 5 %,
- tracking of both joints on ID (Table 8), in units of 0.25 points,
- peaks of speed and torque above what the board permits, in units of 2 %.
"""

from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from repro.config.model import Configuration
from repro.experiments.accepted import experiment_config
from repro.experiments.arm import (
    Recording,
    control_constants,
    disturbance,
    limits,
    program_settings,
    true_parameters,
)
from repro.identification.least_squares import METHODS
from repro.identification.regression import Regression
from repro.matching.compiled import record
from repro.matching.unknowns import TrackingOrder
from repro.model.dynamics import rebuild_torque
from repro.model.parameters import Array
from repro.paper.metric_search import torque_bounds
from repro.paper.published import Published, load_published
from repro.signals.metric import PUBLISHED_METRIC, Similarity, metr2ev
from repro.signals.programs import PROGRAMS, peaks, reference_trajectory
from repro.streams import Stream, stream

FREQUENCY_UNIT, TIME_UNIT, BOUND_UNIT, TRACKING_UNIT, PEAK_UNIT = 1.5, 0.5, 0.05, 0.25, 0.02
#: An experiment is accepted if all of these are satisfied: rms distance of the ten totals of least squares (points),
#: torque over its bound in every cell, distance of each tracking (points). Peaks must be within the limits.
MAX_TOTALS_RMS, MAX_OVER_BOUND, MAX_TRACKING_DISTANCE = 2.0, 1.15, 0.6
#: Smallest error in time that a printed 100.00 % could hide.
SMALLEST_ERROR = 1e-4


@dataclass(frozen=True)
class Printed:
    """The printed numbers: motions ID to T4, then joints."""

    time: Array  # of least squares (5, 2), %
    frequency: Array
    total: Array
    bound: Array  # largest mean-square torque (5, 2), (N m)^2
    tracking: Array  # (2,), %


@lru_cache(maxsize=1)
def published() -> Published:
    """Read the published numbers once: they are needed in every step."""
    return load_published()


@lru_cache(maxsize=1)
def printed() -> Printed:
    """Select those that an experiment must agree with."""
    p = published()

    def cells(factor: str) -> Array:
        return np.array([[p[f"table10/{m}/least-squares/{factor}/joint{j}"].value for j in (1, 2)] for m in PROGRAMS])

    bounds = torque_bounds(p).set_index(["case", "joint"])["largest_mean_square"]
    tracking = np.array([p[f"table08/ID/total/joint{j}"].value for j in (1, 2)])
    return Printed(
        cells("time"), cells("frequency"), cells("total"), bounds.unstack().loc[list(PROGRAMS)].to_numpy(), tracking
    )


@dataclass(frozen=True)
class Motion:
    """What one recording of an experiment gives."""

    regression: Regression
    tracking: Array  # similarity of measured and desired position (2,), %
    peak: Array  # largest needed speed and torque of both joints over their limits (4,)


def record_motion(experiment: Configuration, name: str) -> Motion:
    """Simulate one recording of an experiment; of T1 the first motion that its seed draws, whatever its limits."""
    rng = stream(experiment.experiment.seed, Stream.RANDOM_MOTION)
    program = reference_trajectory(name, program_settings(experiment), rng)
    beta, control, (effects, phase) = (
        true_parameters(experiment),
        control_constants(experiment),
        disturbance(experiment),
    )
    position, pwm = record(beta, effects, phase, control, program.q, program.h)
    return motion_of(
        Recording.of_counts(program, position.astype(np.float64), pwm.astype(np.float64), experiment), experiment
    )


def motion_of(recording: Recording, experiment: Configuration) -> Motion:
    """Evaluate a recording."""
    program = recording.program
    (torque_limit, speed_limit), (speed, torque) = limits(experiment), peaks(program, true_parameters(experiment))
    proper = slice(program.n1, program.n2)
    tracking = 100.0 * metr2ev(program.q[:, proper], recording.q[:, proper]).total
    peak = np.concatenate([speed / speed_limit, torque / np.array(torque_limit)])
    return Motion(recording.regression(experiment.signals), tracking, peak)


@dataclass(frozen=True)
class Outcome:
    """An experiment's numbers next to the printed ones."""

    motions: Mapping[str, Motion]
    order: TrackingOrder

    @cached_property
    def least_squares(self) -> Array:
        """Parameters (9,) of plain least squares on ID."""
        return METHODS["ordinary"].estimate(self.motions["ID"].regression).beta

    def score(self, beta: Array) -> Similarity:
        """Similarity (5, 2) of the torques that parameters (9,) rebuild."""
        regressions = [motion.regression for motion in self.motions.values()]
        each = [metr2ev(r.tau, rebuild_torque(r.y, beta)) for r in regressions]
        return Similarity(np.stack([s.time for s in each]), np.stack([s.frequency for s in each]))

    @cached_property
    def scored(self) -> Similarity:
        """Similarity (5, 2) of least squares."""
        return self.score(self.least_squares)

    @cached_property
    def mean_square(self) -> Array:
        """Mean-square torque (5, 2), (N m)^2."""
        return np.stack([np.mean(motion.regression.tau**2, -1) for motion in self.motions.values()])

    @property
    def tracking(self) -> Array:
        """Distance (2,) of the tracking on ID from the print, points."""
        target = printed().tracking
        return self.motions["ID"].tracking - (target if self.order == "printed" else target[::-1])

    @property
    def over_bound(self) -> Array:
        """Mean-square torque (5, 2) over its bound."""
        return np.asarray(self.mean_square / printed().bound)

    @property
    def totals_rms(self) -> float:
        """Rms distance of the ten totals of least squares, points."""
        return float(np.sqrt(np.mean((100.0 * self.scored.total - printed().total) ** 2)))

    @property
    def terms(self) -> dict[str, Array]:
        """Terms of the misfit before they are squared, by what they compare."""

        def error(percent: Array) -> Array:
            return np.log(np.maximum(1.0 - (percent / 100.0) ** (1.0 / PUBLISHED_METRIC.exponent), SMALLEST_ERROR))

        peak = np.stack([motion.peak for motion in self.motions.values()])
        return {
            "frequency": (100.0 * self.scored.frequency - printed().frequency) / FREQUENCY_UNIT,
            "time": (error(100.0 * self.scored.time) - error(printed().time)) / TIME_UNIT,
            "torque": np.log(np.maximum(self.over_bound, 1.0)) / BOUND_UNIT,
            "tracking": self.tracking / TRACKING_UNIT,
            "peak": np.log(np.maximum(peak, 1.0)) / PEAK_UNIT,
        }

    @property
    def misfit(self) -> float:
        """Sum of squares of all terms."""
        return float(sum(np.sum(term**2) for term in self.terms.values()))

    @property
    def accepted(self) -> bool:
        """Whether the print does not rule the experiment out."""
        return bool(
            self.totals_rms <= MAX_TOTALS_RMS
            and (self.over_bound <= MAX_OVER_BOUND).all()
            and (np.abs(self.tracking) <= MAX_TRACKING_DISTANCE).all()
            and all((motion.peak <= 1.0).all() for motion in self.motions.values())
        )


def outcome_of(values: Mapping[Hashable, Any], order: TrackingOrder, config: Configuration) -> Outcome:
    """Simulate an experiment on all motions."""
    experiment = experiment_config(values, config)
    return Outcome({name: record_motion(experiment, name) for name in PROGRAMS}, order)
