"""MJCF of two links: what MuJoCo reads."""

from repro.export.links import LinkSet, principal_inertia
from repro.export.markup import comment, name_attribute, numbers

_HEAD = (
    "Two-joint arm from identified parameters. Lengths in m, masses in kg, angles in rad.",
    "At q = 0 the arm hangs along -z; joint2 is relative to link1. The motors take torques in N m, unlimited.",
    "Friction: damping is viscous (b). frictionloss is the Coulomb torque (k), in MuJoCo's own form: a constraint",
    "that holds the joint at rest up to this torque, not the k tanh(lambda dq) it was identified with.",
    "Planar motion shows the inertia about the joints' axis alone; the others are those of a slender rod.",
)

_TEXT = """\
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
    return _TEXT.format(
        name=name_attribute(name),
        head=comment(_HEAD + notes, "  "),
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
