"""Two links that have given parameters beta of Eq. 1 exactly, where such links exist, and their URDF and MJCF.

Eq. 1 fixes five combinations of the links, and the links have seven numbers, so two of them are free. Write

    a = g2 / g = m2 lc2,    c = g1 / g = m1 lc1 + m2 l1,    D = I1 - I3 = m1 lc1^2 + J1 + m2 l1^2.

Then I2 = 2 l1 a fixes ``l1 = I2 / (2 a)``, and the masses are free within what keeps both J positive:

- ``J2 = I3 - a^2 / m2 > 0`` holds exactly where ``m2 > a^2 / I3``;
- ``R = D - m2 l1^2 = m1 lc1^2 + J1`` must be positive, exactly where ``m2 < D / l1^2``;
- ``J1 = R - s^2 / m1 > 0`` with ``s = c - m2 l1 = m1 lc1`` holds exactly where ``m1 > s^2 / R``, which some m1 does
  once R is positive.

So links exist if and only if a^2 / I3 < D / l1^2, that is I3 (I1 - I3) > I2^2 / 4: M(q) is positive definite.

Which of them is taken
----------------------
``m2 = 2 a / l2``, which puts the centre of mass in the middle of link 2, if l2 is known and this leaves J2 and R a fair
share of I3 and D. Otherwise the geometric mean of both bounds, in ratio equally far from either: with
``r = I2 / (2 sqrt(I3 D))``, which is below 1, it gives ``J2 = (1 - r) I3`` and ``R = (1 - r) D``.

``m1 = max(3 R / l1^2, 4 s^2 / (3 R))``: the mass of a uniform rod of length l1 that has the inertia R about joint 1,
or more where J1 would otherwise fall below R / 4, its share in such a rod. The centre of mass is then no farther than
l1 / 2 from joint 1. It lies behind the joint (lc1 < 0) if s < 0: a counterweight outweighs the rest of link 1.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import sqrt
from xml.etree.ElementTree import Comment, Element, SubElement, indent, tostring

from repro.model.parameters import NAMES, STANDARD_GRAVITY, Array, check_beta

#: Share of I3 and D that J2 and R keep at least, if the centre of mass of link 2 is to be put in its middle.
MIN_SHARE = 0.05

#: Inertia of a rod about its long axis over that about a transverse one; simulators refuse an inertia of 0.
SLENDERNESS = 0.1

#: Limits of the length of a link, m. A length beyond them comes of a g2 or an I2 too near zero to fix one.
MIN_LENGTH_M, MAX_LENGTH_M = 1e-3, 1e3

#: Limits of every positive number, SI: far beyond any arm, well within what floats square and divide.
MIN_SIZE, MAX_SIZE = 1e-12, 1e12


@dataclass(frozen=True)
class LinkSet:
    """Two links and the friction of their joints."""

    m1: float  # masses, kg
    m2: float
    l1: float  # lengths, m. (l2 does not enter the dynamics.)
    l2: float
    lc1: float  # place of each centre of mass along its link, from its joint, m; lc1 may be negative
    lc2: float
    j1: float  # inertia about each centre of mass and the joint's axis, kg m^2
    j2: float
    b: tuple[float, float]  # viscous friction of each joint, N m s/rad
    k: tuple[float, float]  # coulomb friction of each joint, N m
    gravity: float = STANDARD_GRAVITY  # gravitational acceleration, m/s^2
    notes: tuple[str, ...] = ()  # what was chosen or found on the way, one line each
    rotor: float = 0.0  # inertia of the rotor of joint 2 about its axis, next to I3, kg m^2

    @property
    def rows(self) -> Iterator[tuple[int, float, float, float, float, float, float, float]]:
        """Each link's number, distance from the joint before, length, centre of mass, mass, inertia, b and k."""
        yield 1, 0.0, self.l1, self.lc1, self.m1, self.j1, self.b[0], self.k[0]
        yield 2, self.l1, self.l2, self.lc2, self.m2, self.j2, self.b[1], self.k[1]


def principal_inertia(planar: float) -> tuple[float, float, float]:
    """Principal moments of a slender rod along z, of which planar motion shows that about y alone."""
    return planar, planar, SLENDERNESS * planar


def _check_sizes(values: dict[str, float]) -> None:
    """Refuse a number that is not positive, or of no arm's size."""
    for name, value in values.items():
        if not MIN_SIZE <= value <= MAX_SIZE:
            raise ValueError(f"{name} = {value:.4g} must be positive, between {MIN_SIZE:g} and {MAX_SIZE:g}.")


def _check_possible(beta: Array) -> None:
    """Refuse parameters that no two links can have."""
    i1, i2, i3, g1, g2 = beta[:5].tolist()
    for name, value in zip(NAMES[5:], beta[5:], strict=True):
        if value < 0.0:
            raise ValueError(f"{name} = {value:.4g}: friction must not be negative.")
    if abs(g1) > MAX_SIZE:
        raise ValueError(f"g1 = {g1:.4g} must be below {MAX_SIZE:g} in size.")
    if i2 < 0.0 and g2 < 0.0:
        raise ValueError(
            f"I2 = {i2:.4g} and g2 = {g2:.4g} must be positive: with both negative, q2 = 0 is not where link 2 extends"
            " link 1, or the centre of mass of link 2 lies behind joint 2."
        )
    if g2 < 0.0:
        raise ValueError(f"g2 = {g2:.4g} must be positive: q = 0 must hang down, and gravity act downwards.")
    if g2 < MIN_SIZE:
        raise ValueError(f"g2 = {g2:.4g} must be positive: without gravity on link 2, l1 = I2 g / (2 g2) is not fixed.")
    if i2 < MIN_SIZE:
        raise ValueError(f"I2 = {i2:.4g} must be positive: with g2 = {g2:.4g} no length l1 = I2 g / (2 g2) is.")
    _check_sizes({"I1": i1, "I2": i2, "I3": i3, "g2": g2})
    if i3 * (i1 - i3) <= 0.25 * i2 * i2:
        raise ValueError(
            f"I3 (I1 - I3) = {i3 * (i1 - i3):.4g} must be above I2^2 / 4 = {0.25 * i2 * i2:.4g}: M(q) is not positive"
            " definite, and that of two links is."
        )


def horizontal_links_of(beta: Array, lengths: tuple[float, float] | None) -> LinkSet:
    """Links of given lengths that have the parameters of an arm in a horizontal plane, with link 1 a uniform rod.

    Gravity does not turn its joints, so l1 fixes the first moment a = I2 / (2 l1), and that of link 1 is free.
    """
    beta = check_beta(beta).copy()
    if lengths is None:
        raise ValueError("In a horizontal plane no log determines l1: give link_lengths in the arm file.")
    beta[4] = beta[1] * STANDARD_GRAVITY / (2.0 * lengths[0])
    free = links_of(beta, STANDARD_GRAVITY, lengths)
    rest = beta[0] - beta[2] - free.m2 * free.l1**2
    beta[3] = (free.m2 * free.l1 + 1.5 * rest / free.l1) * STANDARD_GRAVITY
    links = links_of(beta, STANDARD_GRAVITY, lengths)
    note = "the plane is horizontal: gravity turns no joint and is left out, and link 1 is drawn as a uniform rod"
    return replace(links, gravity=0.0, notes=(*links.notes, note))


def links_of(beta: Array, gravity: float = STANDARD_GRAVITY, lengths: tuple[float, float] | None = None) -> LinkSet:
    """Links that have the nine parameters (9,), up to rounding."""
    beta = check_beta(beta)
    i1, i2, i3, g1, g2, b1, b2, k1, k2 = beta.tolist()
    sizes = {} if lengths is None else {"given l1": lengths[0], "given l2": lengths[1]}
    _check_sizes({"gravity": gravity, **sizes})
    _check_possible(beta)
    first, d = g2 / gravity, i1 - i3  # a, D
    l1 = i2 / (2.0 * first)
    if not MIN_LENGTH_M <= l1 <= MAX_LENGTH_M:
        raise ValueError(f"l1 = I2 g / (2 g2) = {l1:.4g} m is no arm's length: I2 = {i2:.4g}, g2 = {g2:.4g}.")

    notes = []
    if lengths is not None:
        notes.append(
            f"the parameters imply l1 = I2 g / (2 g2) = {l1:.4g} m, {100.0 * (l1 / lengths[0] - 1.0):+.1f} % off the "
            f"given {lengths[0]:.4g} m; the implied length is used"
        )

    # 1 - r from 1 - r^2, which does not cancel near the edge where M(q) is singular.
    square = i2 * i2 / (4.0 * i3 * d)
    share = (i3 * d - 0.25 * i2 * i2) / (i3 * d) / (1.0 + sqrt(square))
    m2, j2, rest = (first / l1) * sqrt(d / i3), share * i3, share * d
    how = f"the geometric mean of its bounds {first * first / i3:.4g} and {d / (l1 * l1):.4g} kg"
    if lengths is not None:
        middle = 2.0 * first / lengths[1]
        of_middle = i3 - first * first / middle, d - middle * l1 * l1
        if of_middle[0] >= MIN_SHARE * i3 and of_middle[1] >= MIN_SHARE * d:
            m2, (j2, rest) = middle, of_middle
            how = "so that the centre of mass of link 2 is in its middle"
        else:
            how += f", since a centre of mass in the middle of link 2 would need {middle:.4g} kg"
    if share < MIN_SHARE:
        notes.append(
            f"M(q) is nearly singular, I2^2 / 4 is {square:.6g} of I3 (I1 - I3), so J1 and J2 are small and m1 is"
            " a formal number, not a weight"
        )
    notes.append(f"m2 = {m2:.4g} kg was chosen: {how}")

    moment = g1 / gravity - m2 * l1  # s
    m1 = max(3.0 * rest / (l1 * l1), 4.0 * moment * moment / (3.0 * rest))
    j1 = rest - moment * (moment / m1)
    notes.append(f"m1 = {m1:.4g} kg was chosen: as a uniform rod of length l1, or as much as leaves J1 a rod's share")
    if moment < 0.0:
        notes.append(f"the centre of mass of link 1 lies behind joint 1: lc1 = {moment / m1:.4g} m")
    lc2 = first / m2
    if lengths is None:
        notes.append("l2 is not known and does not enter the dynamics; it is drawn as 2 lc2")
    l2 = 2.0 * lc2 if lengths is None else lengths[1]
    return LinkSet(m1, m2, l1, l2, moment / m1, lc2, j1, j2, (b1, b2), (k1, k2), gravity, tuple(notes))


#: Characters that XML 1.0 does not allow, or advises against.
_NO_XML = re.compile("[^\x20-\x7e\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
#: Placeholder limit of each joint, rad: beyond what an arm without slip rings turns.
_TURNS = 100.0
#: Axis of both joints: -y, so that positive q moves a hanging arm towards +x, as in Fig. 1.
_AXIS = "0 -1 0"

_URDF_HEAD = (
    "Two-joint arm from identified parameters. Lengths in m, masses in kg, angles in rad.",
    "At q = 0 the arm hangs along -z; joint2 is relative to link1; gravity must be set along -z, {gravity} m/s^2.",
    "Friction: damping is viscous (b). The value of friction is the Coulomb torque (k); a simulator applies its own",
    "law for it (often a stick-slip limit, sometimes nothing), not the k tanh(lambda dq) it was identified with.",
    "Position, effort and velocity limits are placeholders: a log does not tell them.",
    "Planar motion shows the inertia about the joints' axis alone; ixx and izz are those of a slender rod.",
    "URDF has no inertia of rotors: that of joint 1 is part of link 1, and that of joint 2 is left out.",
)
_MJCF_HEAD = (
    "Two-joint arm from identified parameters. Lengths in m, masses in kg, angles in rad.",
    "At q = 0 the arm hangs along -z; joint2 is relative to link1. The motors take torques in N m, unlimited.",
    "Friction: damping is viscous (b). frictionloss is the Coulomb torque (k), in MuJoCo's own form: a constraint",
    "that holds the joint at rest up to this torque, not the k tanh(lambda dq) it was identified with.",
    "Planar motion shows the inertia about the joints' axis alone; the others are those of a slender rod.",
    "armature is the inertia of the rotor of joint 2, where the log shows one; that of joint 1 is part of link 1.",
)


def _clean(name: str) -> str:
    """Replace characters that XML does not allow; an arm without a name gets one."""
    return _NO_XML.sub("_", " ".join(name.split())) or "arm"


def _numbers(*values: float) -> str:
    """Print decimal numbers that read back as the same floats."""
    return " ".join(repr(float(value) + 0.0) for value in values)  # + 0.0: no negative zero


def _below(distance: float) -> str:
    return _numbers(0.0, 0.0, -distance)


def _document(root: Element, head: tuple[str, ...], notes: tuple[str, ...]) -> str:
    """Print an XML document with a comment at its head, one line of text to a line."""
    lines = "\n".join(f"    {line}" for line in (*head, *(f"Note: {note}." for note in notes)))
    root.insert(0, Comment("\n" + re.sub("-(?=-)", "- ", lines) + "\n  "))
    indent(root)
    return f'<?xml version="1.0" encoding="utf-8"?>\n{tostring(root, encoding="unicode")}\n'


def urdf(links: LinkSet, name: str) -> str:
    """Print the robot description of an arm; positive q moves a hanging arm towards +x, as in Fig. 1."""
    robot = Element("robot", name=_clean(name))
    SubElement(robot, "link", name="base")
    for number, start, length, centre, mass, inertia, damping, friction in links.rows:
        joint = SubElement(robot, "joint", name=f"joint{number}", type="revolute")
        SubElement(joint, "parent", link=f"link{number - 1}" if number > 1 else "base")
        SubElement(joint, "child", link=f"link{number}")
        SubElement(joint, "origin", xyz=_below(start), rpy="0 0 0")
        SubElement(joint, "axis", xyz=_AXIS)
        SubElement(joint, "limit", lower=_numbers(-_TURNS), upper=_numbers(_TURNS), effort="1000.0", velocity="1000.0")
        SubElement(joint, "dynamics", damping=_numbers(damping), friction=_numbers(friction))
        link = SubElement(robot, "link", name=f"link{number}")
        inertial = SubElement(link, "inertial")
        SubElement(inertial, "origin", xyz=_below(centre), rpy="0 0 0")
        SubElement(inertial, "mass", value=_numbers(mass))
        ixx, iyy, izz = (_numbers(moment) for moment in principal_inertia(inertia))
        SubElement(inertial, "inertia", ixx=ixx, ixy="0", ixz="0", iyy=iyy, iyz="0", izz=izz)
        visual = SubElement(link, "visual")
        SubElement(visual, "origin", xyz=_below(0.5 * length), rpy="0 0 0")
        geometry = SubElement(visual, "geometry")
        SubElement(geometry, "cylinder", radius=_numbers(0.04 * length), length=_numbers(length))
    SubElement(robot, "link", name="tool")
    tool = SubElement(robot, "joint", name="tool_joint", type="fixed")
    SubElement(tool, "parent", link="link2")
    SubElement(tool, "child", link="tool")
    SubElement(tool, "origin", xyz=_below(links.l2), rpy="0 0 0")
    head = tuple(line.format(gravity=_numbers(links.gravity)) for line in _URDF_HEAD)
    return _document(robot, head, links.notes)


def mjcf(links: LinkSet, name: str) -> str:
    """Print the MuJoCo model of an arm, with torque motors; positive q moves a hanging arm towards +x, as in Fig. 1."""
    model = Element("mujoco", model=_clean(name))
    SubElement(model, "compiler", angle="radian")
    SubElement(model, "option", gravity=_below(links.gravity), timestep="0.001", integrator="implicitfast")
    default = SubElement(model, "default")
    SubElement(default, "joint", type="hinge", axis=_AXIS)
    SubElement(default, "geom", type="capsule", contype="0", conaffinity="0")
    body, actuator = SubElement(model, "worldbody"), SubElement(model, "actuator")
    for number, start, length, centre, mass, inertia, damping, friction in links.rows:
        place = {"pos": _below(start)} if number > 1 else {}
        body = SubElement(body, "body", {"name": f"link{number}", **place})
        joint = {"name": f"joint{number}", "damping": _numbers(damping), "frictionloss": _numbers(friction)}
        if number == 2 and links.rotor > 0.0:
            joint["armature"] = _numbers(links.rotor)
        SubElement(body, "joint", joint)
        moments = _numbers(*principal_inertia(inertia))
        SubElement(body, "inertial", pos=_below(centre), mass=_numbers(mass), diaginertia=moments)
        SubElement(body, "geom", fromto=f"{_below(0.0)} {_below(length)}", size=_numbers(0.04 * length))
        SubElement(actuator, "motor", name=f"motor{number}", joint=f"joint{number}")
    SubElement(body, "site", name="tool", pos=_below(links.l2))
    return _document(model, _MJCF_HEAD, links.notes)
