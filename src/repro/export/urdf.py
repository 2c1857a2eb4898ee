"""URDF of two links: what ROS, pinocchio and most simulators read."""

from repro.export.links import LinkSet, principal_inertia
from repro.export.markup import comment, name_attribute, numbers

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
