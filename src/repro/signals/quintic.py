"""Fifth-degree polynomials between two states: the shortest form that meets position, velocity and acceleration."""

import numpy as np

from repro.model.parameters import Array

# Rows: value, first and second derivative of s^3, s^4, s^5 at s = 1.
_END = np.array([[1.0, 1.0, 1.0], [3.0, 4.0, 5.0], [6.0, 12.0, 20.0]])


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
    at_end = np.stack([low.sum(0), v0 + a0, a0])
    coefficients = np.concatenate([low, np.linalg.solve(_END, goal - at_end)])  # (6, J), ascending
    return np.asarray(np.polynomial.polynomial.polyval(np.asarray(t) / duration, coefficients))
