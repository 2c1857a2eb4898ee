"""Two links as URDF, which ROS, pinocchio and most simulators read, and as MJCF, which MuJoCo reads."""

import re
from xml.etree.ElementTree import Comment, Element, SubElement, indent, tostring

from repro.export.links import LinkSet, principal_inertia

#: Characters that XML 1.0 allows and does not advise against, except tab and line ends.
_RANGES = ((0x20, 0x7E), (0xA0, 0xD7FF), (0xE000, 0xFFFD), (0x10000, 0x10FFFF))
#: Name of an arm that has none.
_UNNAMED = "arm"
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
)
_MJCF_HEAD = (
    "Two-joint arm from identified parameters. Lengths in m, masses in kg, angles in rad.",
    "At q = 0 the arm hangs along -z; joint2 is relative to link1. The motors take torques in N m, unlimited.",
    "Friction: damping is viscous (b). frictionloss is the Coulomb torque (k), in MuJoCo's own form: a constraint",
    "that holds the joint at rest up to this torque, not the k tanh(lambda dq) it was identified with.",
    "Planar motion shows the inertia about the joints' axis alone; the others are those of a slender rod.",
)


def _clean(name: str) -> str:
    """Replace characters that XML does not allow."""
    text = " ".join(name.split())
    return "".join(c if any(low <= ord(c) <= high for low, high in _RANGES) else "_" for c in text) or _UNNAMED


def _numbers(*values: float) -> str:
    """Print decimal numbers that read back as the same floats."""
    return " ".join(repr(float(value) + 0.0) for value in values)  # + 0.0: no negative zero


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
    rows = (
        (1, "base", 0.0, links.l1, links.lc1, links.m1, links.j1),
        (2, "link1", links.l1, links.l2, links.lc2, links.m2, links.j2),
    )
    for number, parent, start, length, centre, mass, inertia in rows:
        joint = SubElement(robot, "joint", name=f"joint{number}", type="revolute")
        SubElement(joint, "parent", link=parent)
        SubElement(joint, "child", link=f"link{number}")
        SubElement(joint, "origin", xyz=_numbers(0.0, 0.0, -start), rpy="0 0 0")
        SubElement(joint, "axis", xyz=_AXIS)
        SubElement(joint, "limit", lower=_numbers(-_TURNS), upper=_numbers(_TURNS), effort="1000.0", velocity="1000.0")
        damping, friction = links.b[number - 1], links.k[number - 1]
        SubElement(joint, "dynamics", damping=_numbers(damping), friction=_numbers(friction))

        link = SubElement(robot, "link", name=f"link{number}")
        inertial = SubElement(link, "inertial")
        SubElement(inertial, "origin", xyz=_numbers(0.0, 0.0, -centre), rpy="0 0 0")
        SubElement(inertial, "mass", value=_numbers(mass))
        ixx, iyy, izz = (_numbers(moment) for moment in principal_inertia(inertia))
        SubElement(inertial, "inertia", ixx=ixx, ixy="0", ixz="0", iyy=iyy, iyz="0", izz=izz)
        visual = SubElement(link, "visual")
        SubElement(visual, "origin", xyz=_numbers(0.0, 0.0, -0.5 * length), rpy="0 0 0")
        geometry = SubElement(visual, "geometry")
        SubElement(geometry, "cylinder", radius=_numbers(0.04 * length), length=_numbers(length))
    SubElement(robot, "link", name="tool")
    tool = SubElement(robot, "joint", name="tool_joint", type="fixed")
    SubElement(tool, "parent", link="link2")
    SubElement(tool, "child", link="tool")
    SubElement(tool, "origin", xyz=_numbers(0.0, 0.0, -links.l2), rpy="0 0 0")
    head = tuple(line.format(gravity=_numbers(links.gravity)) for line in _URDF_HEAD)
    return _document(robot, head, links.notes)


def mjcf(links: LinkSet, name: str) -> str:
    """Print the MuJoCo model of an arm, with torque motors; positive q moves a hanging arm towards +x, as in Fig. 1."""
    model = Element("mujoco", model=_clean(name))
    SubElement(model, "compiler", angle="radian")
    gravity = _numbers(0.0, 0.0, -links.gravity)
    SubElement(model, "option", gravity=gravity, timestep="0.001", integrator="implicitfast")
    default = SubElement(model, "default")
    SubElement(default, "joint", type="hinge", axis=_AXIS)
    SubElement(default, "geom", type="capsule", contype="0", conaffinity="0")
    body = SubElement(SubElement(model, "worldbody"), "body", name="link1")
    _mjcf_link(body, 1, links.b[0], links.k[0], links.lc1, links.m1, links.j1, links.l1)
    body = SubElement(body, "body", name="link2", pos=_numbers(0.0, 0.0, -links.l1))
    _mjcf_link(body, 2, links.b[1], links.k[1], links.lc2, links.m2, links.j2, links.l2)
    SubElement(body, "site", name="tool", pos=_numbers(0.0, 0.0, -links.l2))
    actuator = SubElement(model, "actuator")
    for number in (1, 2):
        SubElement(actuator, "motor", name=f"motor{number}", joint=f"joint{number}")
    return _document(model, _MJCF_HEAD, links.notes)


def _mjcf_link(
    body: Element, number: int, b: float, k: float, centre: float, mass: float, inertia: float, length: float
) -> None:
    """Add joint, inertia and shape of a link to its body."""
    SubElement(body, "joint", name=f"joint{number}", damping=_numbers(b), frictionloss=_numbers(k))
    moments = _numbers(*principal_inertia(inertia))
    SubElement(body, "inertial", pos=_numbers(0.0, 0.0, -centre), mass=_numbers(mass), diaginertia=moments)
    span = _numbers(0.0, 0.0, 0.0, 0.0, 0.0, -length)
    SubElement(body, "geom", fromto=span, size=_numbers(0.04 * length))
