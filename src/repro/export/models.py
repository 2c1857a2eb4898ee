"""Two links as URDF, which ROS, pinocchio and most simulators read, and as MJCF, which MuJoCo reads."""

import re
from xml.sax.saxutils import quoteattr

from repro.export.links import LinkSet, principal_inertia

#: Characters that XML 1.0 allows and does not advise against, except tab and line ends.
_RANGES = ((0x20, 0x7E), (0xA0, 0xD7FF), (0xE000, 0xFFFD), (0x10000, 0x10FFFF))

#: Name of an arm that has none.
UNNAMED = "arm"


def name_attribute(name: str) -> str:
    """Quoted and escaped attribute value of a name."""
    text = " ".join(name.split())
    clean = "".join(c if any(low <= ord(c) <= high for low, high in _RANGES) else "_" for c in text)
    return quoteattr(clean or UNNAMED)


def comment(lines: tuple[str, ...], indent: str) -> str:
    """XML comment, one line of text to a line."""
    body = re.sub("-(?=-)", "- ", "\n".join(f"{indent}  {line}" for line in lines))
    return f"{indent}<!--\n{body}\n{indent}-->"


def numbers(*values: float) -> str:
    """Decimal numbers that read back as the same floats, parted by blanks."""
    return " ".join(repr(float(value) + 0.0) for value in values)  # + 0.0: no negative zero


_HEAD = (
    "Two-joint arm from identified parameters. Lengths in m, masses in kg, angles in rad.",
    "At q = 0 the arm hangs along -z; joint2 is relative to link1; gravity must be set along -z, {gravity} m/s^2.",
    "Friction: damping is viscous (b). The value of friction is the Coulomb torque (k); a simulator applies its own",
    "law for it (often a stick-slip limit, sometimes nothing), not the k tanh(lambda dq) it was identified with.",
    "Position, effort and velocity limits are placeholders: a log does not tell them.",
    "Planar motion shows the inertia about the joints' axis alone; ixx and izz are those of a slender rod.",
)

_LINK = """\
  <link name="{link}">
    <inertial>
      <origin xyz="{centre}" rpy="0 0 0"/>
      <mass value="{mass}"/>
      <inertia ixx="{ixx}" ixy="0" ixz="0" iyy="{iyy}" iyz="0" izz="{izz}"/>
    </inertial>
    <visual>
      <origin xyz="{middle}" rpy="0 0 0"/>
      <geometry>
        <cylinder radius="{radius}" length="{length}"/>
      </geometry>
    </visual>
  </link>"""

_JOINT = """\
  <joint name="{joint}" type="revolute">
    <parent link="{parent}"/>
    <child link="{child}"/>
    <origin xyz="{origin}" rpy="0 0 0"/>
    <axis xyz="0 -1 0"/>
    <limit lower="{lower}" upper="{upper}" effort="1000.0" velocity="1000.0"/>
    <dynamics damping="{damping}" friction="{friction}"/>
  </joint>"""

_TOOL = """\
  <link name="tool"/>
  <joint name="tool_joint" type="fixed">
    <parent link="link2"/>
    <child link="tool"/>
    <origin xyz="{end}" rpy="0 0 0"/>
  </joint>"""

#: Placeholder limit of each joint, rad: beyond what an arm without slip rings turns.
_TURNS = 100.0


def urdf(links: LinkSet, name: str) -> str:
    """Robot description of the arm.

    The axis of both joints is -y, so that positive q moves a hanging arm towards +x, as in Fig. 1.
    """
    notes = tuple(f"Note: {note}." for note in links.notes)
    head = tuple(line.format(gravity=numbers(links.gravity)) for line in _HEAD)
    parts = [
        '<?xml version="1.0" encoding="utf-8"?>',
        f"<robot name={name_attribute(name)}>",
        comment(head + notes, "  "),
        '  <link name="base"/>',
    ]
    rows = (
        (1, "base", 0.0, links.l1, links.lc1, links.m1, links.j1),
        (2, "link1", links.l1, links.l2, links.lc2, links.m2, links.j2),
    )
    for number, parent, start, length, centre, mass, inertia in rows:
        ixx, iyy, izz = principal_inertia(inertia)
        parts.append(
            _JOINT.format(
                joint=f"joint{number}",
                parent=parent,
                child=f"link{number}",
                origin=numbers(0.0, 0.0, -start),
                lower=numbers(-_TURNS),
                upper=numbers(_TURNS),
                damping=numbers(links.b[number - 1]),
                friction=numbers(links.k[number - 1]),
            )
        )
        parts.append(
            _LINK.format(
                link=f"link{number}",
                centre=numbers(0.0, 0.0, -centre),
                mass=numbers(mass),
                ixx=numbers(ixx),
                iyy=numbers(iyy),
                izz=numbers(izz),
                middle=numbers(0.0, 0.0, -0.5 * length),
                radius=numbers(0.04 * length),
                length=numbers(length),
            )
        )
    parts += [_TOOL.format(end=numbers(0.0, 0.0, -links.l2)), "</robot>"]
    return "\n".join(parts) + "\n"


_MJCF_HEAD = (
    "Two-joint arm from identified parameters. Lengths in m, masses in kg, angles in rad.",
    "At q = 0 the arm hangs along -z; joint2 is relative to link1. The motors take torques in N m, unlimited.",
    "Friction: damping is viscous (b). frictionloss is the Coulomb torque (k), in MuJoCo's own form: a constraint",
    "that holds the joint at rest up to this torque, not the k tanh(lambda dq) it was identified with.",
    "Planar motion shows the inertia about the joints' axis alone; the others are those of a slender rod.",
)

_MJCF = """\
<?xml version="1.0" encoding="utf-8"?>
<mujoco model={name}>
{head}
  <compiler angle="radian"/>
  <option gravity="{gravity}" timestep="0.001" integrator="implicitfast"/>
  <default>
    <joint type="hinge" axis="0 -1 0"/>
    <geom type="capsule" contype="0" conaffinity="0"/>
  </default>
  <worldbody>
    <body name="link1">
      <joint name="joint1" damping="{b1}" frictionloss="{k1}"/>
      <inertial pos="{centre1}" mass="{m1}" diaginertia="{inertia1}"/>
      <geom fromto="{span1}" size="{radius1}"/>
      <body name="link2" pos="{end1}">
        <joint name="joint2" damping="{b2}" frictionloss="{k2}"/>
        <inertial pos="{centre2}" mass="{m2}" diaginertia="{inertia2}"/>
        <geom fromto="{span2}" size="{radius2}"/>
        <site name="tool" pos="{end2}"/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <motor name="motor1" joint="joint1"/>
    <motor name="motor2" joint="joint2"/>
  </actuator>
</mujoco>
"""


def mjcf(links: LinkSet, name: str) -> str:
    """MuJoCo model of the arm.

    The axis of both joints is -y, so that positive q moves a hanging arm towards +x, as in Fig. 1.
    """
    notes = tuple(f"Note: {note}." for note in links.notes)
    return _MJCF.format(
        name=name_attribute(name),
        head=comment(_MJCF_HEAD + notes, "  "),
        gravity=numbers(0.0, 0.0, -links.gravity),
        b1=numbers(links.b[0]),
        b2=numbers(links.b[1]),
        k1=numbers(links.k[0]),
        k2=numbers(links.k[1]),
        m1=numbers(links.m1),
        m2=numbers(links.m2),
        centre1=numbers(0.0, 0.0, -links.lc1),
        centre2=numbers(0.0, 0.0, -links.lc2),
        inertia1=numbers(*principal_inertia(links.j1)),
        inertia2=numbers(*principal_inertia(links.j2)),
        span1=numbers(0.0, 0.0, 0.0, 0.0, 0.0, -links.l1),
        span2=numbers(0.0, 0.0, 0.0, 0.0, 0.0, -links.l2),
        end1=numbers(0.0, 0.0, -links.l1),
        end2=numbers(0.0, 0.0, -links.l2),
        radius1=numbers(0.04 * links.l1),
        radius2=numbers(0.04 * links.l2),
    )
