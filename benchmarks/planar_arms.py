"""A second family of simulated arms, without code of the package: two rigid links, exact torques, no control loop.

Masses, lengths and inertias are drawn and the nine parameters follow from them. The motion is a quintic spline through
random knots, so that its derivatives are exact. The torque is the sum of moments of both links (Newton and Euler).
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import make_interp_spline

GRAVITY = 9.81
RATE = 250.0
SECONDS = 25.0
#: Steps of an encoder of 8192 counts, rad, and noise of the torque as a share of the RMS torque.
ENCODER, NOISE = 2.0 * np.pi / 8192.0, 0.01
#: Torque that depends on the position: fewest periods a turn, one more than the most, largest amplitude over g1.
WAVES = {"position": (1, 8, 0.06), "cogging": (20, 80, 0.08)}
#: Effects beyond Eq. 1.
KINDS = {
    "clean": "none",
    "coarse": "encoder and noise 8 times as coarse",
    "offset": "torque offsets, 3 and 5 % of the load",
    "scale1": "torque of joint 1 wrong by 15 %",
    "constant": "torque constant falls by 5 to 15 % with the current",
    "position": "torque of 1 to 7 periods a turn (board: 4), 2 to 6 % of g1",
    "cogging": "torque of 20 to 79 periods a turn (board: 49), 2 to 8 % of g1",
    "friction": "Stribeck friction, 20 to 50 % of k, and (planar) friction up to 6 % of the load",
    "temperature": "b and k fall by 20 to 50 %",
    "rotor5": "rotor of joint 2, 5 % of I3",
    "rotor30": "rotor of joint 2, 30 % of I3",
    "flexible": "elastic gear behind the encoder, 0.3 to 1.5 degrees",
    "backlash": "backlash behind the encoder, 0.2 to 1 degree",
    "rotor30+flexible": "that rotor and an elastic gear",
    "rotor30+backlash": "that rotor and backlash",
}


@dataclass(frozen=True)
class Arm:
    """Two links as masses and lengths, with the friction of both joints."""

    mass: np.ndarray
    length: float
    centre: np.ndarray
    inertia: np.ndarray
    viscous: np.ndarray
    coulomb: np.ndarray
    steepness: float

    @property
    def beta(self) -> np.ndarray:
        """I1, I2, I3, g1, g2, b1, b2, k1, k2."""
        (m1, m2), (c1, c2), (j1, j2), a = self.mass, self.centre, self.inertia, self.length
        own = j2 + m2 * c2**2
        inertia = [j1 + m1 * c1**2 + m2 * a**2 + own, 2.0 * m2 * a * c2, own]
        return np.array([*inertia, GRAVITY * (m1 * c1 + m2 * a), GRAVITY * m2 * c2, *self.viscous, *self.coulomb])


@dataclass(frozen=True)
class Motion:
    """Time (s) and the motion of both joints, shape (2, n)."""

    t: np.ndarray
    q: np.ndarray
    dq: np.ndarray
    ddq: np.ndarray


def draw_arm(rng: np.random.Generator) -> Arm:
    """Draw masses of 0.4 to 2.5 kg, lengths of 0.2 to 0.4 m and friction of some percent of the load."""
    mass = np.array([rng.uniform(0.8, 2.5), rng.uniform(0.4, 1.5)])
    lengths = rng.uniform(0.2, 0.4, 2)
    centre = lengths * rng.uniform(0.3, 0.6, 2)
    inertia = mass * lengths**2 * rng.uniform(0.05, 0.12, 2)
    load = GRAVITY * np.array([mass @ [centre[0], lengths[0]], mass[1] * centre[1]])
    coulomb, viscous = load * rng.uniform(0.03, 0.15, 2), load * rng.uniform(0.01, 0.06, 2)
    return Arm(mass, float(lengths[0]), centre, inertia, viscous, coulomb, rng.uniform(15.0, 50.0))


def draw_motion(rng: np.random.Generator) -> Motion:
    """Draw a quintic spline through knots 0.7 to 1.2 s apart, which begin before the log and end after it."""
    t = np.arange(0.0, SECONDS, 1.0 / RATE)
    knots = np.arange(-5.0, SECONDS + 5.0, rng.uniform(0.7, 1.2))
    places = rng.normal(0.0, 0.6, (2, knots.size)) + rng.uniform(-0.3, 0.3, (2, 1))
    spline = make_interp_spline(knots, places, k=5, axis=1)
    return Motion(t, spline(t), spline(t, 1), spline(t, 2))


def _moment(arm: np.ndarray, force: np.ndarray) -> np.ndarray:
    return arm[0] * force[1] - arm[1] * force[0]


def rigid_torque(arm: Arm, m: Motion) -> np.ndarray:
    """Torque of the joints without friction, shape (2, n), from forces and moments of both links."""
    angle, speed, turn = (np.cumsum(x, axis=0) for x in (m.q, m.dq, m.ddq))

    def placed(k: int, r: float) -> tuple[np.ndarray, np.ndarray]:
        along, across = np.array([np.sin(angle[k]), -np.cos(angle[k])]), np.array([np.cos(angle[k]), np.sin(angle[k])])
        return r * along, r * (turn[k] * across - speed[k] ** 2 * along)

    (elbow, elbow_moves), (first, first_moves) = placed(0, arm.length), placed(0, arm.centre[0])
    second, second_moves = placed(1, arm.centre[1])
    up = np.array([[0.0], [GRAVITY]])
    force1, force2 = arm.mass[0] * (first_moves + up), arm.mass[1] * (elbow_moves + second_moves + up)
    joint2 = arm.inertia[1] * turn[1] + _moment(second, force2)
    return np.stack([arm.inertia[0] * turn[0] + _moment(first, force1) + joint2 + _moment(elbow, force2), joint2])


def friction_torque(arm: Arm, m: Motion) -> np.ndarray:
    """Viscous and Coulomb friction, shape (2, n)."""
    return arm.viscous[:, None] * m.dq + arm.coulomb[:, None] * np.tanh(arm.steepness * m.dq)


def warm_up(t: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Relative change of friction while an arm warms up, with mean zero."""
    fall = np.exp(-t / 8.0)
    return rng.uniform(0.2, 0.5) * (fall - fall.mean())


def disturbed(kind: str, arm: Arm, m: Motion, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Position and torque of both joints, each (2, n), with the effects of one of `KINDS`."""
    q, rigid, friction = m.q, rigid_torque(arm, m), friction_torque(arm, m)
    torque, largest = rigid + friction, np.abs(rigid).max(axis=-1, keepdims=True)
    for part in kind.split("+"):
        match part:
            case "position" | "cogging":
                low, high, share = WAVES[part]
                wave = np.sin(rng.integers(low, high, (2, 1)) * q + rng.uniform(0.0, 2.0 * np.pi, (2, 1)))
                torque += rng.uniform(0.02, share) * arm.beta[3] * np.array([[1.0], [0.5]]) * wave
            case "friction":
                stribeck = rng.uniform(0.2, 0.5) * np.exp(-((m.dq / rng.uniform(0.1, 0.4)) ** 2))
                size = stribeck * arm.coulomb[:, None] + rng.uniform(0.0, 0.06) * np.abs(rigid)
                torque += size * np.tanh(arm.steepness * m.dq)
            case "temperature":
                torque += warm_up(m.t, rng) * friction
            case "rotor5" | "rotor30":
                torque[1] += float(part.removeprefix("rotor")) / 100.0 * arm.beta[2] * m.ddq[1]
            case "flexible":
                q = q + np.radians(rng.uniform(0.3, 1.5, (2, 1))) * rigid / largest
            case "backlash":
                q = q + np.radians(rng.uniform(0.1, 0.5, (2, 1))) * np.tanh(rigid / (0.05 * largest))
            case "constant":
                current = np.abs(torque) / np.abs(torque).max(axis=-1, keepdims=True)
                torque *= 1.0 + rng.uniform(0.05, 0.15, (2, 1)) * current ** rng.integers(1, 4)
            case "scale1":
                torque[0] *= rng.choice([0.85, 1.15])
            case "offset":
                torque += np.array([[0.03], [0.05]]) * largest
    return q, torque


def record(
    q: np.ndarray, torque: np.ndarray, rng: np.random.Generator, coarse: float = 1.0
) -> tuple[np.ndarray, np.ndarray]:
    """Position and torque as a log would contain them; `coarse` multiplies encoder step and noise."""
    size, step = np.sqrt(np.mean(torque**2, axis=-1, keepdims=True)), coarse * ENCODER
    return step * np.rint(q / step), torque + coarse * NOISE * size * rng.normal(size=torque.shape)
