"""Checks of the audit that are one calculation on the published numbers of their row in ``findings.csv``."""

import math
from collections.abc import Callable
from operator import ge, gt, le, lt

from repro.paper.finding import Check, Finding


def _band_high(c: Check) -> Finding:
    h = c.period / 1000
    steps, highest = round(c.duration * math.pi / h), c.bands - 1
    found, needed = highest / (2 * h * steps), highest / (2 * h * c.high)
    return c.equals(found, c.high, steps=steps, highest=highest, h=h, needed=needed)


def _labels(c: Check) -> Finding:
    label = 1 / (1 + math.exp(1))
    return c.equals(-math.log((1 - label) / label), 1.0, 0.0, label=label)


def _counts(c: Check) -> tuple[float, int, float]:
    """Counts of a motor turn that the printed resolution gives, the whole number next to it, and those of a joint."""
    motor_turn = 2 * math.pi / (c.step * c.gear)
    counts = round(motor_turn)
    return motor_turn, counts, counts * c.gear


def _encoder_step(c: Check) -> Finding:
    motor_turn, counts, joint_turn = _counts(c)
    found = 2 * math.pi / joint_turn
    return c.equals(found, c.step, motor_turn=motor_turn, counts=counts, joint_turn=joint_turn)


def _position_turns(c: Check) -> Finding:
    _, _, joint_turn = _counts(c)
    return c.equals(c.high / joint_turn, c.turns, joint_turn=joint_turn)


def _full_torque(c: Check) -> Finding:
    return c.related(c.full, le, c.motor, share=100 * c.full / c.motor, unit=1e3 * c.full / c.count)


def _velocity_gain(c: Check) -> Finding:
    found = c.gain * c.step
    return c.related(found, le, c.full, continuous=c.gain * c.h / 1000, share=100 * found / c.full)


def _frame(c: Check) -> Finding:
    used = 8 * c.identifier + c.fields * c.position + c.joints * c.bits
    return c.related(used, le, c.frame)


def _rate(c: Check) -> Finding:
    bytes_per_second = c.frame / 8 / (c.h / 1000)
    return c.compares(10 * bytes_per_second, math.nan, False, bytes_per_second=bytes_per_second)


def _memory_share(c: Check) -> Finding:
    trajectory, memory = 8192 * c.joints * 32, 608256
    return c.equals(100 * trajectory / memory, c.memory, rest=c.memory * memory / 100 - trajectory)


def _circle(c: Check) -> Finding:
    reach = 100 * c.tip / c.speed
    return c.related(c.circle, lt, reach, share=c.circle / reach)


def _condition(c: Check) -> Finding:
    scale = c.rho * c.epsilon
    largest = c.r2_max / scale
    return c.related(largest / c.r1_min, lt, 1 / scale, largest=largest)


#: Checks by the id of their row.
ARITHMETIC: dict[str, Callable[[Check], Finding]] = {
    "section6/experimental/threshold": lambda c: c.related((c.first + c.second) / 2, gt, c.threshold),
    "range/reach": lambda c: c.related(c.tip / c.speed, le, 3 * c.limit, reach=2 * c.limit),
    "section3/sampling-rate": lambda c: c.equals(1000 / c.period, c.rate),
    "section4a/band-high": _band_high,
    "eq16/blue": lambda c: c.related(c.weight / 3 + 1, le, 1.0),
    "section4b/train-images": lambda c: c.equals(c.share * c.sets / 100, c.images, 0.0),
    "section4b/test-images": lambda c: c.equals(c.share * c.sets / 100, c.images, 0.0),
    "section4b/loss-divisor": lambda c: c.equals(c.terms, c.divisor, 0.0),
    "section4b/learning-rate-slope": lambda c: c.related(c.start + c.slope * c.steps, le, c.start),
    "section4b/labels": _labels,
    "section3/encoder-step": _encoder_step,
    "section3/position-turns": _position_turns,
    "section3/position-low": lambda c: c.equals(c.high - c.low + 1, 2**c.bits, 0.0),
    "section3/torque-unit": lambda c: c.equals(100 / c.high, c.unit, more=c.high + 1, of_more=100 / (c.high + 1)),
    "section3/torque-bits": lambda c: c.equals(c.high - c.low + 1, 2**c.bits, 0.0),
    "section3/torque-low": lambda c: c.related(c.low * (100 / c.high), ge, -100.0, unit=100 / c.high),
    "section5c/full-torque/joint1": _full_torque,
    "section5c/full-torque/joint2": _full_torque,
    "table08/kv/joint1": _velocity_gain,
    "section3/frame": _frame,
    "section3/rate": _rate,
    "section3/logic-share": lambda c: c.equals(100 * c.elements / c.of, c.share),
    "section3/memory-share": _memory_share,
    "section6/T2/circle": _circle,
    "appendix/condition": _condition,
    "appendix/rate": lambda c: c.related(c.dissipation, gt, c.coupling),
    "appendix/gain": lambda c: c.equals(1 / (c.rho * c.epsilon), 1.0, 0.0),
}
