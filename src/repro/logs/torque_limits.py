"""Torque that is not the one that acted: at the limit of drive or sensor, or stuck while the arm moves."""

import numpy as np
from numpy.typing import NDArray

from repro.identification.filtering import MAX_CONTAMINATION
from repro.identification.log import Log, cached_per_log, period
from repro.logs.conventions import fit_joints, low_pass, smoothed
from repro.model.dynamics import regressor
from repro.model.parameters import Array

_MAX_STEPS = 50.0  # most steps of a change that is used: rounding of printed numbers adds up
_MIN_RUNS_AT_LIMIT = 5  # fewest samples at an extreme value that can be a limit, in typical runs of equal values
#: Ratio of samples at the extreme value to those at any of the next levels, steps below it, if it is a limit.
_MIN_LIMIT_RATIO, _NEXT_LEVELS = 4.0, (1, 2, 3)
_MAX_LEVELS = 8  # different values of a torque that is switched among levels, not limited, at most
_MIN_REPEATED = 3  # samples of each value between these: a limited torque passes through others each time
_MIN_SWITCHED = 0.9  # fraction of the samples of a switched torque at one of its two levels, at least
#: Shortest time for which a stuck torque is constant, s, fewest samples, and their number over that of usual runs.
_MIN_STUCK_S, _MIN_STUCK_SAMPLES, _MIN_STUCK_RATIO = 0.03, 5, 5.0
_USUAL_QUANTILE = 0.9  # quantile of the lengths of runs that is usual
#: Motion under a stuck torque, rad, and jump at its begin or end in steps of the torque, at least.
_MIN_MOTION_RAD, _MIN_JUMP_STEPS = 0.01, 3.0
#: Error of Eq. 1 there over the error elsewhere, from which the recorded torque is not the one that acted,
_MIN_ERROR_RATIO = 1.5
#: and largest fraction of a joint's samples that may be left out.
_MAX_LEFT_OUT = 0.5


def quantisation_step(x: Array) -> float | None:
    """Find the smallest change of which most changes are multiples; None if there is none."""
    changes = np.abs(np.diff(x))
    changes = changes[changes > 1e-9 * np.abs(x).max(initial=0.0)]
    if changes.size < 20:
        return None
    small = changes[changes <= _MAX_STEPS * changes.min()]
    if small.size < max(20, 0.3 * changes.size):
        return None
    step = float(small.min())
    for _ in range(3):  # what was printed with few digits is a multiple on average
        step = float(small.sum() / np.rint(small / step).sum())
    apart = np.abs(small / step - np.rint(small / step))
    return step if float((apart < 0.1).mean()) > 0.9 else None


@cached_per_log
def saturated(log: Log) -> NDArray[np.bool_]:
    """Find the samples (2, N) whose torque is at its limit, or at an extreme value at which it accumulates."""
    if log.torque_limit is not None:
        return np.asarray(np.abs(log.tau) >= 0.999 * log.torque_limit[:, np.newaxis])
    return np.stack([_at_extremes(tau) for tau in log.tau])


def _is_switched(tau: Array) -> bool:
    """Whether a torque (N,) is one of two opposite levels nearly always: it is known, although no drive gives more."""
    levels, counts = np.unique(tau, return_counts=True)
    two = np.argsort(counts)[-2:]
    low, high = np.sort(levels[two])
    enough = counts[two].sum() > _MIN_SWITCHED * tau.size and counts[two].min() > (1.0 - _MIN_SWITCHED) * tau.size
    repeated = tau.size - counts[two].sum() >= _MIN_REPEATED * (levels.size - 2)
    largest = np.abs(tau).max() <= 1.001 * max(-low, high)
    return bool(enough and repeated and largest and low < 0.0 < high)


def _runs(x: Array) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """First samples of the runs of equal values, and those after their last."""
    begins = np.flatnonzero(np.abs(np.diff(x)) > 1e-9 * np.abs(x).max()) + 1
    return np.concatenate([[0], begins]), np.concatenate([begins, [x.size]])


def _at_extremes(tau: Array) -> NDArray[np.bool_]:
    """Find the samples (N,) at the extreme values, if they accumulate there."""
    largest, found = float(np.abs(tau).max()), np.zeros(tau.size, dtype=np.bool_)
    if np.unique(tau).size <= _MAX_LEVELS or _is_switched(tau):
        return found
    step = quantisation_step(tau) or 1e-6 * largest
    typical = float(np.median(np.subtract(*_runs(tau)[::-1])))
    for side in (tau, -tau):
        top = float(side.max())
        if top < 0.5 * largest:
            continue
        steps_below = np.rint((top - side) / step)
        at_top = steps_below == 0.0
        n, most = np.count_nonzero(at_top), max(np.count_nonzero(steps_below == k) for k in _NEXT_LEVELS)
        if n >= _MIN_RUNS_AT_LIMIT * typical and n > _MIN_LIMIT_RATIO * most:
            found |= at_top
    return found


def _stuck(tau: Array, q: Array, h: float) -> NDArray[np.bool_]:
    """Find the samples (N,) of a torque that is constant for exceptionally long while its joint moves, and jumps."""
    begins, ends = _runs(tau)
    length = ends - begins
    fewest = max(_MIN_STUCK_SAMPLES, _MIN_STUCK_S / h, _MIN_STUCK_RATIO * float(np.quantile(length, _USUAL_QUANTILE)))
    step, found = quantisation_step(tau) or 0.0, np.zeros(tau.size, dtype=np.bool_)
    for k in np.flatnonzero(length >= fewest):
        begin, end = begins[k], ends[k]
        jumps = np.abs(np.diff(tau[max(begin - 1, 0) : end + 1]))
        lasts = end == tau.size and begin > 0
        if np.ptp(q[begin:end]) > _MIN_MOTION_RAD and (lasts or jumps.max(initial=0.0) > _MIN_JUMP_STEPS * step):
            found[begin:end] = True
    return found


def unreliable_torque(log: Log) -> NDArray[np.bool_]:
    """Find the samples (2, N) of a uniformly sampled log whose torque Eq. 1 contradicts, at a limit or stuck.

    Eq. 1 is fitted to the other samples. A drive that reports the torque it gives at its limit agrees with it there,
    and a torque of zero before the drives are switched on or after they are switched off is no stuck one.
    """
    if log.breaks:
        return np.concatenate([unreliable_torque(piece) for piece in log.pieces], axis=1)
    h, on = period(log), np.any(log.tau != 0.0, axis=0)
    driven = np.logical_or.accumulate(on) & np.logical_or.accumulate(on[::-1])[::-1]
    stuck = np.stack([_stuck(tau, q, h) for tau, q in zip(log.tau, log.q, strict=True)])
    suspected = saturated(log) | (stuck & driven)
    if not suspected.any():
        return suspected
    s = smoothed(log)
    k = s.chosen
    rows = np.abs(low_pass(suspected.astype(np.float64), h)[:, k]) > MAX_CONTAMINATION
    y = regressor(s.q[:, k], s.dq[:, k], s.ddq[:, k])
    beta, _ = fit_joints(y * ~rows[..., np.newaxis], s.tau[:, k] * ~rows)
    square = (y @ beta - s.tau[:, k]) ** 2
    for joint in (0, 1):
        there = rows[joint]
        few = 0.0 < there.mean() <= _MAX_LEFT_OUT
        if not few or square[joint, there].mean() <= _MIN_ERROR_RATIO**2 * square[joint, ~there].mean():
            suspected[joint] = False
    return suspected
