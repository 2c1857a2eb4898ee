"""A recording of a two-joint arm in SI units."""

from dataclasses import dataclass

from repro.model.parameters import Array


@dataclass(frozen=True)
class Log:
    """What was recorded, in SI units and the angles of Eq. 1.

    Attributes
    ----------
    name : str
        File name without folders.
    t : array of shape (N,)
        Time of each sample, s: strictly increasing, not necessarily uniform.
    q : array of shape (2, N)
        Position, rad: ``q1 = 0`` hangs down, ``q2`` is relative to link 1.
    tau : array of shape (2, N)
        Torque at the joints, N m.
    dq : array of shape (2, N) or None
        Measured velocity, rad/s, if it was recorded.
    notes : tuple of str
        What was assumed or converted on reading, one line each.
    simulated : bool
        Whether it comes from the simulated board.
    torque_limit : array of shape (2,) or None
        Largest torque the drives can give, N m, where it is known.
    """

    name: str
    t: Array
    q: Array
    tau: Array
    dq: Array | None = None
    notes: tuple[str, ...] = ()
    simulated: bool = False
    torque_limit: Array | None = None
