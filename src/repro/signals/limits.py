"""May an arm run a program? Peak joint speed and torque against what the motors can do."""

import numpy as np

from repro.errors import InputError
from repro.model.dynamics import inverse_dynamics
from repro.model.parameters import Array
from repro.signals.programs import VALIDATION, Program, ProgramSettings, program

#: What the arm can do (Section III, V-C): full PWM of each joint, N m, and joint speed, rad/s.
TORQUE_LIMIT = (2.7192, 2.7314)
SPEED_LIMIT = 8.0


def peaks(desired: Program, beta: Array) -> tuple[Array, Array]:
    """Peak speed and torque that a program asks of an arm.

    Parameters
    ----------
    desired : Program
        Desired positions.
    beta : array of shape (9,)
        Nominal parameters of the arm, SI units.

    Returns
    -------
    speed, torque : arrays of shape (2,)
        Largest magnitude for each joint: of the steps between samples, the first one from q = 0 (rad/s), and of
        the inverse dynamics with central differences (N m).

    Raises
    ------
    ValueError
        If `beta` is not valid.
    """
    q = np.pad(desired.q, ((0, 0), (1, 0)))  # the arm hangs at rest before the first sample
    step = np.diff(q) / desired.h
    dq = 0.5 * (step[:, 1:] + step[:, :-1])
    torque = inverse_dynamics(q[:, 1:-1], dq, np.diff(step) / desired.h, beta)
    return np.abs(step).max(-1), np.abs(torque).max(-1)


def check_limits(
    desired: Program, beta: Array, torque_limit: tuple[float, float] = TORQUE_LIMIT, speed_limit: float = SPEED_LIMIT
) -> None:
    """Refuse a program that an arm cannot run; to be called before anything is sent to it.

    Parameters
    ----------
    desired : Program
        Desired positions.
    beta : array of shape (9,)
        Nominal parameters of the arm, SI units.
    torque_limit : tuple of float
        Torque at full PWM of each joint, N m.
    speed_limit : float
        Of each joint, rad/s.

    Raises
    ------
    InputError
        If a joint would have to turn faster or harder than its limit.
    """
    speed, torque = peaks(desired, beta)
    asked = (("speed", "rad/s", speed, (speed_limit, speed_limit)), ("torque", "N m", torque, torque_limit))
    for quantity, unit, found, allowed in asked:
        for joint in range(2):
            if not found[joint] <= allowed[joint]:
                place = f"trajectory {desired.name}: joint {joint + 1} {quantity}"
                raise InputError.at(place, f"{found[joint]:.4g} {unit}", f"at most {allowed[joint]:g} {unit}")


def permitted_program(
    name: str,
    settings: ProgramSettings,
    rng: np.random.Generator,
    beta: Array,
    torque_limit: tuple[float, float] = TORQUE_LIMIT,
    speed_limit: float = SPEED_LIMIT,
    draws: int = 100,
) -> Program:
    """Program that keeps the limits; a random one is drawn again until it does.

    All of 100 draws of T1 with its 12 bands keep the torque limit on an arm with I1 = 0.12 kg m^2; with 45 bands, 2 of
    10 do.

    Parameters
    ----------
    name : str
        Which motion.
    settings : ProgramSettings
        Lengths, filter and geometry.
    rng : numpy.random.Generator
        Source of random numbers.
    beta : array of shape (9,)
        Nominal parameters of the arm, SI units.
    torque_limit : tuple of float
        Torque at full PWM of each joint, N m.
    speed_limit : float
        Of each joint, rad/s.
    draws : int
        How often a random one may be drawn.

    Returns
    -------
    Program
        Checked by `check_limits`.

    Raises
    ------
    InputError
        If the program, or the last of the draws, breaks a limit, or it is longer than the board's memory.
    ValueError
        If `draws` is less than 1 or a setting is not valid.
    """
    if draws < 1:
        raise ValueError(f"draws: must be at least 1, got {draws}.")
    for _ in range(draws - 1 if name in VALIDATION and VALIDATION[name].random else 0):
        desired = program(name, settings, rng)
        speed, torque = peaks(desired, beta)
        if (speed <= speed_limit).all() and (torque <= np.asarray(torque_limit)).all():
            return desired
    desired = program(name, settings, rng)
    check_limits(desired, beta, torque_limit, speed_limit)
    return desired
