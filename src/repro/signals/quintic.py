"""Fifth-degree polynomials between two states: the shortest form that meets position, velocity and acceleration."""

import numpy as np

from repro.model.parameters import Array

# Rows: second and first derivative, and value, of s^3, s^4, s^5 at s = 1; in this order elimination needs no pivoting.
_END = np.array([[6.0, 12.0, 20.0], [3.0, 4.0, 5.0], [1.0, 1.0, 1.0]])


def _upper_coefficients(missing: Array) -> Array:
    """Solve ``_END c = missing``, shape (3, J), by elimination: the last bits of a solver depend on the processor."""
    a, c = _END.copy(), missing.copy()
    for k in range(3):
        factor = a[k + 1 :, k, None] / a[k, k]
        a[k + 1 :] -= factor * a[k]
        c[k + 1 :] -= factor * c[k]
    for k in (2, 1, 0):
        c[k] *= 1.0 / a[k, k]
        c[:k] -= a[:k, k, None] * c[k]
    return c


def quintic(t: Array, duration: float, start: Array, end: Array) -> Array:
    """Quintic that leaves one state at time 0 and arrives in another at `duration`.

    Parameters
    ----------
    t : array of shape (N,)
        Times, s.
    duration : float
        s.
    start, end : arrays of shape (3, J)
        Position (rad), velocity (rad/s) and acceleration (rad/s^2) of J joints.

    Returns
    -------
    array of shape (J, N)
        Positions, rad.

    Raises
    ------
    ValueError
        If `duration` is not positive, a state does not have three rows, or a value is not finite.
    """
    if not 0 < duration < np.inf:
        raise ValueError(f"duration: must be positive and finite, got {duration}.")
    states = np.asarray([start, end], dtype=np.float64)
    if states.ndim != 3 or states.shape[1] != 3 or not np.isfinite(states).all():
        raise ValueError(f"start, end: must be finite of shape (3, joints), got shape {states.shape[1:]}.")
    # In s = t / duration a velocity is scaled by the duration, an acceleration by its square.
    (p0, v0, a0), goal = states * (duration ** np.arange(3))[:, None]
    low = np.stack([p0, v0, 0.5 * a0])
    at_end = np.stack([a0, v0 + a0, low.sum(0)])
    coefficients = np.concatenate([low, _upper_coefficients(goal[::-1] - at_end)])  # (6, J), ascending
    return np.asarray(np.polynomial.polynomial.polyval(np.asarray(t) / duration, coefficients))
