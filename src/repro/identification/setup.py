"""What the set-up gets wrong, found in the log: zero positions, offsets of the torques, scale of one to the other.

A zero that is off turns gravity, an offset of the torque is always there, and a torque constant of one joint that is
wrong shows because both joints share I2, I3 and g2. Each is a column beside the nine
(`repro.identification.more_columns`); the values follow by Gauss-Newton on the log corrected by them.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from repro.identification.alternatives import bias, columns_of, zero_position
from repro.identification.filtering import FilterSettings, prepare
from repro.identification.more_columns import (
    ENOUGH,
    SURE,
    best_set,
    fitted_with_errors,
    least_seen,
    nine_of,
    reduced,
    rows,
)
from repro.identification.regression import Regression, drop_standstill
from repro.identification.solve import solve
from repro.logs.log import Log
from repro.model.dynamics import regressor
from repro.model.parameters import NAMES, Array

#: What may be wrong, in the order of the columns: zero of a joint (rad), offset of its torque (N m), and the recorded
#: torque of joint 2 over the one that Eq. 1 shares with joint 1.
FAULTS = ("zero1", "zero2", "offset1", "offset2", "scale2")
#: Zero beyond which this is no small fault but another reading of the log, see `repro.logs.conventions`, rad.
FAR = 0.25
#: Factor beyond which the scale of a torque is no fault of the set-up but a joint that the log tells nothing of.
LARGE = 3.0
#: Longest step of an iteration: rad, and share of the scale. Columns hold near the log that they are made on.
STEP = {"zero": 0.1, "scale": 0.3}
#: Most iterations.
ITERATIONS = 8
#: Standard errors that a step may have to be the last.
SETTLED = 0.1


@dataclass(frozen=True)
class Fault:
    """One thing that the set-up gets wrong.

    Attributes
    ----------
    name : str
        Of `FAULTS`.
    value, error : float
        How much, and its standard error: rad to add to the recorded position, N m to take from the recorded torque, or
        the factor that the recorded torque is too large by.
    before, after : float
        Relative RMS error of the rebuilt torque, mean of both joints, with all faults put right but this, and with all.
    instead : dict of str to float
        Other faults, by name with their values, of which one in its place would explain the log nearly as well.
    """

    name: str
    value: float
    error: float
    before: float
    after: float
    instead: dict[str, float] = field(default_factory=dict)


def values_of(found: Sequence[Fault]) -> dict[str, float]:
    """Values by fault."""
    return {fault.name: fault.value for fault in found}


def corrected(log: Log, found: Mapping[str, float]) -> Log:
    """The log with what the set-up got wrong put right.

    Parameters
    ----------
    log : Log
        As recorded.
    found : mapping of str to float
        Values by fault; what is left out is right.

    Returns
    -------
    Log
        With other positions and torques.
    """
    if not found:
        return log
    zero, offset = (np.array([[found.get(f"{what}{j}", 0.0)] for j in (1, 2)]) for what in ("zero", "offset"))
    scale = np.array([[1.0], [found.get("scale2", 1.0)]])
    return replace(log, q=log.q + zero, tau=(log.tau - offset) / scale)


def _columns(log: Log, settings: FilterSettings, beta: Array) -> Array:
    """What the torque changes by with each fault, shape (2, n, 5)."""

    def made(moved: tuple[Array, Array, Array], beta: Array, steepness: float) -> Array:
        scaled = np.zeros((2, moved[0].shape[-1], 1))
        scaled[1, :, 0] = (regressor(*moved, steepness) @ beta)[1]
        return np.concatenate([zero_position(moved, beta, steepness), bias(moved, beta, steepness), scaled], axis=-1)

    return columns_of([made], log, settings, beta)[0]


def _relative(regression: Regression, others: Array) -> float:
    """Relative RMS error of least squares of a log and others, mean of its joints that have torque."""
    beta = solve(regression.y, regression.tau)
    if len(others):
        both = np.concatenate([reduced(*rows(regression, np.empty((*regression.tau.shape, 0)))), others])
        beta = solve(both[np.newaxis, :, :-1], both[np.newaxis, :, -1])
    left = np.linalg.norm(regression.tau - regression.y @ beta, axis=-1)
    whole = np.linalg.norm(regression.tau, axis=-1)
    return float(np.mean((left / np.where(whole > 0.0, whole, 1.0))[whole > 0.0])) if whole.any() else 0.0


def _prepared(log: Log, settings: FilterSettings) -> tuple[Regression, Array]:
    """Regression of a log without standstill, and the columns of all faults."""
    r = drop_standstill(prepare(log, settings))
    return r, _columns(log, settings, solve(r.y, r.tau))


def _settle(log: Log, settings: FilterSettings, names: Sequence[str], others: Array) -> dict[str, tuple[float, float]]:
    """Values of these faults with their standard errors, by Gauss-Newton."""
    found = {name: 1.0 if name == "scale2" else 0.0 for name in names}
    chosen = [FAULTS.index(name) for name in names]
    errors = dict.fromkeys(names, np.inf)
    for _ in range(ITERATIONS):
        r, columns = _prepared(corrected(log, found), settings)
        a, b = rows(r, columns[..., chosen])
        steps, spread = (x[len(NAMES) :] for x in fitted_with_errors(a, b, r.h, others))
        for name, step, error in zip(names, steps, spread, strict=True):
            size = found[name] if name == "scale2" else 1.0
            longest = STEP.get(name[:-1], np.inf)
            found[name] += size * float(np.clip(step, -longest, longest))
            errors[name] = abs(size) * float(error)
        if np.all(np.abs(steps) < SETTLED * spread):
            break
    return {name: (found[name], errors[name]) for name in names}


def find_faults(log: Log, settings: FilterSettings, others: Sequence[Regression] = ()) -> tuple[Fault, ...]:
    """Faults of the set-up that a log asks for.

    Parameters
    ----------
    log : Log
        Uniformly sampled.
    settings : FilterSettings
        Filter, delay and lambda.
    others : sequence of Regression
        Other logs of the arm, without a fault or put right: what the nine are there they are here.

    Returns
    -------
    tuple of Fault
        In the order of `FAULTS`; empty for a log without fault.
    """
    r, columns = _prepared(log, settings)
    able, nine = [k for k in range(len(FAULTS)) if np.any(columns[..., k] * r.mask)], nine_of(others)
    names = [FAULTS[k] for k in best_set(*rows(r, columns), able, nine)]
    while names:
        values = _settle(log, settings, names, nine)
        found = [_judged(log, settings, values, name, nine) for name in names]
        wrong = [fault for fault in found if not _sure(fault)]
        if not wrong:
            return tuple(_doubted(log, settings, fault, names, nine) for fault in found)
        # Gauss-Newton may end far away because of one that is not there: without it the others settle.
        least = min(wrong, key=lambda fault: fault.before - fault.after)
        names = [name for name in names if name != least.name]
    return ()


def _sure(fault: Fault) -> bool:
    """Whether a fault is well away from none, near enough to be one, and makes the error smaller."""
    away = abs(fault.value - (fault.name == "scale2"))
    if fault.name == "scale2":
        near = 1.0 / LARGE <= fault.value <= LARGE
    else:
        near = away <= FAR or fault.name.startswith("offset")
    return away > SURE * fault.error and near and fault.after < fault.before


def _judged(
    log: Log, settings: FilterSettings, values: Mapping[str, tuple[float, float]], name: str, others: Array
) -> Fault:
    """A fault with the errors that all faults put right leave, and all but this one."""

    def left(right: Mapping[str, float]) -> float:
        return _relative(drop_standstill(prepare(corrected(log, right), settings)), others)

    right = {other: value for other, (value, _) in values.items()}
    without_it = {other: value for other, value in right.items() if other != name}
    return Fault(name, *values[name], left(without_it), left(right))


def _doubted(log: Log, settings: FilterSettings, fault: Fault, names: Sequence[str], others: Array) -> Fault:
    """A fault with what explains the log nearly as well in its place."""
    instead = {}
    for other in (name for name in FAULTS if name not in names):
        exchanged = [other if name == fault.name else name for name in names]
        rival = _judged(log, settings, _settle(log, settings, exchanged, others), other, others)
        if (1.0 - ENOUGH) * rival.after**2 < fault.after**2 and _sure(rival):
            instead[other] = rival.value
    return replace(fault, instead=instead)


def hidden_faults(
    log: Log, settings: FilterSettings, found: Sequence[Fault], others: Sequence[Regression] = ()
) -> dict[str, float | None]:
    """Faults that could be there and not be found, and up to which size.

    Parameters
    ----------
    log : Log
        Put right by the faults found.
    settings : FilterSettings
        Filter, delay and lambda.
    found : sequence of Fault
        Faults that are put right.
    others : sequence of Regression
        As for `find_faults`.

    Returns
    -------
    dict of str to float or None
        Least size that is found, of each other fault whose joint moves: rad, N m, or the share by which the scale of
        joint 2 is off. None where a fault of any size could be hidden: no zero beyond `FAR`, no scale beyond `LARGE`
        and no offset beyond the largest torque is taken for one.
    """
    r, columns = _prepared(log, settings)
    own = [FAULTS.index(fault.name) for fault in found]
    able = [k for k in range(len(FAULTS)) if k not in own and np.any(columns[..., k] * r.mask)]
    a, b = rows(r, columns)
    largest = np.abs(log.tau).max(axis=-1)
    limit = {"zero1": FAR, "zero2": FAR, "offset1": largest[0], "offset2": largest[1], "scale2": LARGE - 1.0}
    sizes = zip((FAULTS[k] for k in able), least_seen(a, b, own, able, r.h, nine_of(others)), strict=True)
    return {name: size if size < limit[name] else None for name, size in sizes}


def columns_of_faults(log: Log, settings: FilterSettings, beta: Array, found: Sequence[Fault]) -> Array:
    """Columns of the faults that were found, on the log corrected by them, shape (2, n, k)."""
    return _columns(log, settings, beta)[..., [FAULTS.index(fault.name) for fault in found]]
