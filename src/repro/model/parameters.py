"""The nine dynamic parameters beta of Eq. 1: names, units, order, and how links give them (Table 2)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

NAMES = ("I1", "I2", "I3", "g1", "g2", "b1", "b2", "k1", "k2")

# Units derived from Eq. 1. Tables 4 and 5 print kg m^2 s for b and kg m^2/s^2 for g and k; a viscous
# coefficient must be kg m^2/s for B dq to be a torque.
UNITS = ("kg m^2",) * 3 + ("kg m^2/s^2",) * 2 + ("kg m^2/s",) * 2 + ("kg m^2/s^2",) * 2

DESCRIPTIONS = (
    "inertia of both links seen by joint 1",
    "inertial coupling of the links",
    "inertia of link 2 seen by joint 2",
    "gravity load of both links on joint 1",
    "gravity load of link 2",
    "viscous friction of joint 1",
    "viscous friction of joint 2",
    "Coulomb friction of joint 1",
    "Coulomb friction of joint 2",
)

EXPRESSIONS = (
    "m1 lc1^2 + J1 + m2 l1^2 + m2 lc2^2 + J2",
    "2 m2 l1 lc2",
    "m2 lc2^2 + J2",
    "(m1 lc1 + m2 l1) g",
    "m2 lc2 g",
    "b1",
    "b2",
    "k1",
    "k2",
)

STANDARD_GRAVITY = 9.80665


@dataclass(frozen=True)
class Links:
    """Geometry and mass of the two links (Fig. 1), scalars or arrays of one common shape ``S``.

    Attributes
    ----------
    m1, m2 : array of shape S
        Masses, kg.
    l1 : array of shape S
        Length of link 1, m. (l2 does not enter the dynamics.)
    lc1, lc2 : array of shape S
        Distance of each centre of mass from its joint, m.
    j1, j2 : array of shape S
        Inertia about each centre of mass, kg m^2.
    """

    m1: Array | float
    m2: Array | float
    l1: Array | float
    lc1: Array | float
    lc2: Array | float
    j1: Array | float
    j2: Array | float


def inertial_from_links(links: Links, gravity: float = STANDARD_GRAVITY) -> Array:
    """Inertial and gravity parameters of Eq. 1 from the links.

    Parameters
    ----------
    links : Links
        Link parameters of shape ``S``.
    gravity : float
        Gravitational acceleration, m/s^2.

    Returns
    -------
    array of shape S + (5,)
        ``(I1, I2, I3, g1, g2)``.

    Notes
    -----
    Eq. 1, last five lines (Section II).
    """
    i3 = links.m2 * np.square(links.lc2) + links.j2
    i1 = links.m1 * np.square(links.lc1) + links.j1 + links.m2 * np.square(links.l1) + i3
    i2 = 2.0 * links.m2 * links.l1 * links.lc2
    g1 = (links.m1 * links.lc1 + links.m2 * links.l1) * gravity
    g2 = links.m2 * links.lc2 * gravity
    return np.stack(np.broadcast_arrays(i1, i2, i3, g1, g2), axis=-1).astype(np.float64)


def check_beta(beta: Array) -> Array:
    """Return `beta` as float64 after checking that its last axis holds nine finite numbers.

    Parameters
    ----------
    beta : array of shape (..., 9)
        Parameter sets.

    Returns
    -------
    array of shape (..., 9)
        The same numbers.

    Raises
    ------
    ValueError
        If the last axis is not nine long or a value is not finite.
    """
    beta = np.asarray(beta, dtype=np.float64)
    if beta.ndim == 0 or beta.shape[-1] != len(NAMES):
        raise ValueError(f"beta: the last axis must hold {len(NAMES)} parameters, got shape {beta.shape}.")
    if not np.isfinite(beta).all():
        raise ValueError("beta: every parameter must be finite.")
    return beta
