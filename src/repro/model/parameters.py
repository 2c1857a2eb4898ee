"""The nine dynamic parameters beta of Eq. 1: names, units, order, their values for given links, and feasibility."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

# Tables 4 and 5 print kg m^2/s^2, which is N m, for g and k. They print kg m^2 s for b; B dq is a torque, so b is in
# N m s/rad.
_TABLE = (
    ("I1", "kg m^2", "inertia of both links seen by joint 1", "m1 lc1^2 + J1 + m2 l1^2 + m2 lc2^2 + J2"),
    ("I2", "kg m^2", "inertial coupling of the links", "2 m2 l1 lc2"),
    ("I3", "kg m^2", "inertia of link 2 seen by joint 2", "m2 lc2^2 + J2"),
    ("g1", "N m", "gravity load of both links on joint 1", "(m1 lc1 + m2 l1) g"),
    ("g2", "N m", "gravity load of link 2", "m2 lc2 g"),
    ("b1", "N m s/rad", "viscous friction of joint 1", "b1"),
    ("b2", "N m s/rad", "viscous friction of joint 2", "b2"),
    ("k1", "N m", "Coulomb friction of joint 1", "k1"),
    ("k2", "N m", "Coulomb friction of joint 2", "k2"),
)
NAMES, UNITS, DESCRIPTIONS, EXPRESSIONS = (tuple(row[k] for row in _TABLE) for k in range(4))

STANDARD_GRAVITY = 9.80665


@dataclass(frozen=True)
class Links:
    """Geometry and mass of the links (Fig. 1), numbers or arrays of a shape S; the length of link 2 has no effect."""

    m1: Array | float  # masses, kg
    m2: Array | float
    l1: Array | float  # length of link 1, m
    lc1: Array | float  # distance of each centre of mass from its joint, m
    lc2: Array | float
    j1: Array | float  # inertia about each centre of mass, kg m^2
    j2: Array | float


def inertial_from_links(links: Links, gravity: float = STANDARD_GRAVITY) -> Array:
    """Compute (I1, I2, I3, g1, g2) of Eq. 1, shape S + (5,); gravity in m/s^2."""
    i3 = links.m2 * np.square(links.lc2) + links.j2
    i1 = links.m1 * np.square(links.lc1) + links.j1 + links.m2 * np.square(links.l1) + i3
    i2 = 2.0 * links.m2 * links.l1 * links.lc2
    g1 = (links.m1 * links.lc1 + links.m2 * links.l1) * gravity
    g2 = links.m2 * links.lc2 * gravity
    return np.stack(np.broadcast_arrays(i1, i2, i3, g1, g2), axis=-1).astype(np.float64)


def check_beta(beta: ArrayLike) -> Array:
    """Return `beta` (..., 9) as float64, or raise ValueError if it is not nine finite numbers on the last axis."""
    beta = np.asarray(beta, dtype=np.float64)
    if beta.ndim == 0 or beta.shape[-1] != len(NAMES):
        raise ValueError(f"beta: the last axis must hold {len(NAMES)} parameters, got shape {beta.shape}.")
    if not np.isfinite(beta).all():
        raise ValueError("beta: every parameter must be finite.")
    return beta


def is_positive(beta: Array) -> NDArray[np.bool_]:
    """Check (...,) whether all nine parameters (..., 9) are positive, as the paper's own test arms are."""
    return np.asarray((check_beta(beta) > 0.0).all(-1))


def is_positive_definite(beta: Array) -> NDArray[np.bool_]:
    """Check (...,) whether M(q) is positive definite for every q2 and no friction is negative.

    det M = I3 (I1 + I2 c) - (I3 + I2 c / 2)^2 = I3 (I1 - I3) - I2^2 c^2 / 4 is smallest at c^2 = 1.
    """
    beta = check_beta(beta)
    i1, i2, i3 = beta[..., 0], beta[..., 1], beta[..., 2]
    definite = (i3 > 0.0) & (i3 * (i1 - i3) > 0.25 * i2**2)
    return np.asarray(definite & (beta[..., 5:] >= 0.0).all(-1))


#: I2 = 2 m2 l1 lc2 and g2 = m2 lc2 g have the sign of lc2, and g1 = (m1 lc1 + m2 l1) g is positive unless a
#: counterweight outweighs both links about joint 1. A zero half a turn away changes two of the signs, not the product.
SIGNED = (NAMES.index("I2"), NAMES.index("g1"), NAMES.index("g2"))


def has_possible_signs(beta: Array) -> NDArray[np.bool_]:
    """Check (...,) whether I2 g1 g2 >= 0."""
    return np.asarray(check_beta(beta)[..., SIGNED].prod(-1) >= 0.0)


#: Interpretations of "physically possible" (line 22 of Algorithm 1).
FEASIBILITY: dict[str, Callable[[Array], NDArray[np.bool_]]] = {
    "positive": is_positive,
    "positive-definite": is_positive_definite,
}
