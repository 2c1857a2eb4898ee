"""Terms that extend Eq. 1: a rotor, further friction, and what else may act on an arm, as columns next to the nine.

A term (`TERMS`) may be subtracted from the torque; `repro.identification.term_selection` chooses which. An unmodelled
effect (`UNMODELLED_EFFECTS`) only widens intervals. Coulomb friction that differs between the two directions is an
offset while a joint moves.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import product

import numpy as np
from scipy.interpolate import CubicSpline

from repro.identification.filtering import (
    FILTERS,
    MIN_ERROR_REDUCTION,
    FilterSettings,
    Moved,
    filter_columns,
    filtered_torque,
    retained_samples,
    smooth_motion,
)
from repro.identification.log import Log, period
from repro.model.dynamics import regressor
from repro.model.parameters import NAMES, Array

MIN_Z_SCORE = 4.0  # standard errors that a term must be away from no effect
#: Reduction of the cross-validated squared error beyond which friction that is not subtracted is reported.
MIN_REPORTED_REDUCTION = 0.05
POSITION_DIFFERENCE = 1e-4  # difference with which columns of errors of the position are made, rad
#: Speeds at which unmodelled Stribeck friction may have fallen to 1/e of its value at rest, rad/s, and those from which
#: the speed of a Stribeck term is chosen; it may be wrong by half a step between them.
STRIBECK_SPEEDS = (0.1, 0.2, 0.5)
STRIBECK_GRID = tuple(0.05 * 2.0 ** (k / 2.0) for k in range(9))
STRIBECK_FACTORS = (2.0**-0.25, 2.0**0.25)
N_NINE = len(NAMES)
N_LOAD = 5  # inertia and gravity: the first parameters, whose torque loads the gear


@dataclass(frozen=True, eq=False)
class SmoothLog:
    """One piece of a log as the columns of further terms need it."""

    moved: Moved  # smoothed motion
    tau: Array  # filtered torque (2, N)
    beta: Array  # parameters that give the torque of Eq. 1
    h: float  # sampling period, s
    settings: FilterSettings

    @classmethod
    def of(cls, log: Log, settings: FilterSettings, beta: Array) -> "SmoothLog":
        """Smooth a log in one piece."""
        h = period(log)
        return cls(smooth_motion(log.q, h, settings), filtered_torque(log.tau, h, settings), beta, h, settings)

    @cached_property
    def y(self) -> Array:
        """The regressor along the motion (2, N, 9)."""
        return regressor(*self.moved, self.settings.friction_steepness)

    @cached_property
    def coulomb(self) -> Array:
        """Direction of the Coulomb friction of each joint (2, N)."""
        return np.tanh(self.settings.friction_steepness * self.moved[1])

    @cached_property
    def gear_load(self) -> Array:
        """Recorded torque (2, N) behind the friction of each joint: a position error would falsify that of Eq. 1."""
        friction = FILTERS[self.settings.name].apply(self.y[..., 5:] @ self.beta[5:], self.h, self.settings.cutoff, 0)
        return self.tau - friction


Columns = Callable[[SmoothLog], Array]  # torque (2, N, k) that terms of unit size add


def one_joint(values: Array) -> Array:
    """Make a column for each joint that is zero in the other, (2, N) -> (2, N, 2)."""
    return values[..., np.newaxis] * np.eye(2)[:, np.newaxis]


def offset(log: SmoothLog) -> Array:
    """Compute the columns of a constant torque of each joint, shape (2, N, 2)."""
    return one_joint(np.ones_like(log.tau))


def position_error(log: SmoothLog, error: Array) -> Array:
    """Compute the change of both torques with an error (2, N) of the position of either joint, shape (2, N, 2)."""
    torque, moved = log.y @ log.beta, smooth_motion(error, log.h, log.settings)
    columns = []
    for joint, largest in zip(np.eye(2), np.abs(error).max(axis=-1), strict=True):
        difference = POSITION_DIFFERENCE / (largest or 1.0)
        q, dq, ddq = (x + difference * joint[:, np.newaxis] * dx for x, dx in zip(log.moved, moved, strict=True))
        columns.append((replace(log, moved=(q, dq, ddq)).y @ log.beta - torque) / difference)
    return np.stack(columns, axis=-1)


def zero_position(log: SmoothLog) -> Array:
    """Compute the change of the torque of each joint with the zero position of either, shape (2, N, 2)."""
    return position_error(log, np.ones_like(log.tau))


def rotor_inertia(log: SmoothLog) -> Array:
    """Compute the torque of a rotor of unit inertia that turns with joint 2 alone, shape (2, N, 1)."""
    return one_joint(log.moved[2])[..., 1:]


def load_friction(log: SmoothLog) -> Array:
    """Compute Coulomb friction in proportion to the torque that the gear carries, shape (2, N, 2)."""
    return one_joint(np.abs(log.y[..., :N_LOAD] @ log.beta[:N_LOAD]) * log.coulomb)


def torque_friction(log: SmoothLog) -> Array:
    """Compute Coulomb friction in proportion to the recorded torque, which contains it, shape (2, N, 2)."""
    return one_joint(np.abs(log.tau) * log.coulomb)


def stribeck(log: SmoothLog, speed: float | None = None, power: int = 2) -> Array:
    """Compute friction that is larger near rest, shape (2, N, 2): powers of 1 and 2 are both in use."""
    speed = log.settings.stribeck_speed if speed is None else speed
    return one_joint(log.coulomb * np.exp(-((np.abs(log.moved[1]) / speed) ** power)))


def once_a_turn(log: SmoothLog) -> Array:
    """Compute torque of period one turn (eccentric gear), (2, N, 3), without sin q1 at joint 1: it is g1."""
    q = log.moved[0]
    return np.concatenate([one_joint(np.cos(q)), one_joint(np.sin(q))[..., 1:]], axis=-1)


def waves(log: SmoothLog, periods: int) -> Array:
    """Compute torque of so many periods in a turn of its joint (2: cable, gear out of round), shape (2, N, 4)."""
    return np.concatenate([one_joint(wave(periods * log.moved[0])) for wave in (np.cos, np.sin)], axis=-1)


def elasticity(log: SmoothLog) -> Array:
    """Compute the effect of a gear that yields in proportion to its load, behind the encoder, shape (2, N, 2)."""
    return position_error(log, log.gear_load)


def backlash(log: SmoothLog, width: float) -> Array:
    """Compute the effect of play behind the encoder (2, N, 2): teeth change sides below `width` of the largest load."""
    largest = np.abs(log.gear_load).max(axis=-1, keepdims=True)
    return position_error(log, np.tanh(log.gear_load / (width * np.where(largest > 0.0, largest, 1.0))))


ZEROS, OFFSETS, ROTOR_OF_2 = "zero positions", "torque offsets", "inertia of the rotor of joint 2"
CONSTANTS = "torque constants that change with the current"
_STRIBECK = tuple(partial(stribeck, speed=speed, power=power) for speed, power in product(STRIBECK_SPEEDS, (1, 2)))
#: Effects beyond Eq. 1 by name. Of several forms, each the columns of some functions, the one that explains the
#: residual best counts. The teeth of a gear may change sides at several loads over the largest one.
UNMODELLED_EFFECTS: dict[str, tuple[tuple[Columns, ...], ...]] = {
    ZEROS: ((zero_position,),),
    OFFSETS: ((offset,),),
    "load-dependent friction": ((load_friction,),),
    "Stribeck friction": tuple((form,) for form in _STRIBECK),
    "both kinds of friction": tuple((load_friction, form) for form in _STRIBECK),
    "torque of period one turn": ((once_a_turn,),),
    "torque of period half a turn": ((partial(waves, periods=2),),),
    ROTOR_OF_2: ((rotor_inertia,),),
    CONSTANTS: ((lambda log: one_joint(log.tau * np.abs(log.tau)),),),
    "elasticity": ((elasticity,),),
    "backlash": tuple((partial(backlash, width=width),) for width in (0.02, 0.05, 0.15)),
}
EFFECTS_PER_LOG = (ZEROS, OFFSETS)  # effects that differ from log to log of one arm
CERTAIN_EFFECTS = (ROTOR_OF_2,)  # effects that every gear has, of positive size
#: Largest credible torque of an effect, over the largest torque of its joint: beyond it something else looks like it.
MAX_TORQUE_SHARE = {CONSTANTS: 0.3}


@dataclass(frozen=True)
class TermKind:
    """A kind of term, with a column for each of its joints."""

    columns: Columns
    joints: tuple[int, ...] = (1, 2)
    min_reduction: float = MIN_ERROR_REDUCTION  # fraction of the cross-validated squared error that it must reduce
    neutral: float = 0.0  # value without effect
    max_step: float = np.inf  # longest step of Gauss-Newton, as columns are valid near the log that they are made on


#: Friction in proportion to the load, friction at rest on top of k (N m), and the rotor of joint 2 (kg m^2). Every gear
#: has a rotor, and a column that is not needed only widens the intervals: little evidence is enough.
TERMS: dict[str, TermKind] = {
    "load": TermKind(load_friction),
    "stribeck": TermKind(stribeck),
    "rotor": TermKind(rotor_inertia, (2,), min_reduction=MIN_REPORTED_REDUCTION),
}
LOAD = "load"  # the kind of friction that is not linear in the acceleration
STRIBECK = "stribeck"  # the kind of friction with a speed, which changes b and k
ROTOR = "rotor"  # the kind that is no friction: it is subtracted without being asked


def term_names(kinds: Mapping[str, TermKind]) -> tuple[str, ...]:
    """Names of the terms, ``KINDj`` with joint j, in the order of the columns."""
    return tuple(f"{name}{joint}" for name, kind in kinds.items() for joint in kind.joints)


TERM_NAMES = term_names(TERMS)


@dataclass(frozen=True)
class Term:
    """A term that a log shows."""

    name: str  # of `TERM_NAMES` or `repro.identification.calibration.CALIBRATION_TERMS`
    value: float  # in the unit of its kind: a zero is added to the position, an offset subtracted from the torque
    error: float  # standard error of the value

    @property
    def kind(self) -> str:
        """Its name without the joint."""
        return self.name[:-1]


@dataclass(frozen=True)
class ExtraTerm(Term):
    """Friction or a rotor that Eq. 1 does not model."""

    gain: float  # fraction by which it reduces the cross-validated squared error, next to the other terms
    taken: bool  # whether it is subtracted from the torque


def values_of(terms: Sequence[Term]) -> dict[str, float]:
    """Values of terms by name."""
    return {term.name: term.value for term in terms}


# Columns next to those of the regressor.


def raw_columns(kinds: Mapping[str, TermKind], log: SmoothLog) -> Array:
    """Compute the columns of all terms of these kinds, shape (2, N, k)."""
    return np.concatenate([kind.columns(log) for kind in kinds.values()], axis=-1)


def filtered_columns(makes: Sequence[Columns], log: Log, settings: FilterSettings, beta: Array) -> list[Array]:
    """Compute columns at the retained samples through the filters of the regressor, each of shape (2, n, k)."""
    pieces = []
    for piece in log.pieces:
        n, keep = retained_samples(piece, settings)
        smooth = SmoothLog.of(piece.piece(0, n), settings, beta)
        pieces.append([filter_columns(make(smooth), smooth.h, settings)[:, keep] for make in makes])
    return [np.concatenate(parts, axis=1) for parts in zip(*pieces, strict=True)]


def term_columns(
    kinds: Mapping[str, TermKind], log: Log, settings: FilterSettings, beta: Array, terms: Sequence[Term] | None = None
) -> Array:
    """Compute the filtered columns (2, n, k) of terms, or of all terms of these kinds."""
    if terms is not None and not terms:
        return np.empty((2, sum(retained_samples(piece, settings)[1].size for piece in log.pieces), 0))
    columns = filtered_columns([partial(raw_columns, kinds)], log, settings, beta)[0]
    return columns if terms is None else columns[..., [term_names(kinds).index(term.name) for term in terms]]


def subtract_terms(log: Log, settings: FilterSettings, beta: Array, terms: Sequence[ExtraTerm]) -> Log:
    """Subtract these terms from the torque of a log; `beta` gives the load."""
    subset, values = [TERM_NAMES.index(term.name) for term in terms], np.array([term.value for term in terms])
    torques = []
    for piece in log.pieces:
        torque = raw_columns(TERMS, SmoothLog.of(piece, settings, beta))[..., subset] @ values
        acting = np.clip(piece.t + settings.delay, piece.t[0], piece.t[-1])
        torques.append(piece.tau - CubicSpline(piece.t, torque, axis=1)(acting))
    return replace(log, tau=np.concatenate(torques, axis=1))
