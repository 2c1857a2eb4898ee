"""Encoder, serial link and device (Section III) against each other."""

import math

from repro.paper.checks.finding import (
    CONSISTENT,
    CONTRADICTS,
    OPEN,
    OUTSIDE,
    Finding,
    agreement,
)
from repro.paper.published import Published
from repro.signals.programs import MEMORY_SAMPLES

#: Memory of the EP4CE22; like the length of the desired trajectory that fills it best, not printed in the paper.
DEVICE_MEMORY_BITS = 608256
FLOAT_BITS = 32


def encoder(p: Published) -> list[Finding]:
    """Encoder step and position range."""
    step, gear, turns = p["section3/encoder-step"], p["section3/gear-ratio"], p["section3/position-turns"]
    low, high, bits = p["section3/position-low"], p["section3/position-high"], p["section3/position-bits"]
    # The motor's counts a turn are not printed: the whole number that the printed ones lead to.
    motor = round(2.0 * math.pi / (step.value * gear.value))
    counts = motor * gear.value
    rad = 2.0 * math.pi / counts
    span = high.value / counts
    width = 2.0**bits.value
    return [
        Finding(
            step.id,
            step.place,
            "resolution of the encoders",
            f"2 pi / ({step.printed} x {gear.printed}) = {2.0 * math.pi / (step.value * gear.value):.3f} counts a "
            f"motor turn, so {motor} x {gear.printed} = {counts:g} a joint turn: 2 pi / {counts:g} = {rad:.4e} rad",
            rad,
            step.value,
            step.half_step,
            "rad",
            agreement(rad, step.value, step.half_step),
            "The counts of a motor turn are not printed; a whole number of them must give the resolution.",
            (step.id, gear.id),
        ),
        Finding(
            turns.id,
            turns.place,
            "range of the position register",
            f"{high.printed} / {counts:g} = {span:.4f} turns",
            span,
            turns.value,
            turns.half_step,
            "turn",
            agreement(span, turns.value, turns.half_step),
            "",
            (turns.id, high.id, step.id, gear.id),
        ),
        Finding(
            low.id,
            low.place,
            "values of the position register",
            f"{high.printed} - ({low.printed}) + 1 = {high.value - low.value + 1:g} = 2^{bits.printed}",
            high.value - low.value + 1.0,
            width,
            0.0,
            "1",
            agreement(high.value - low.value + 1.0, width, 0.0),
            "The decoder's own register has 32 bits; a frame carries 16.",
            (low.id, high.id, bits.id),
        ),
    ]


def link_and_device(p: Published) -> list[Finding]:
    """Frame, rate of the serial link, logic elements, memory, and the circle of T2."""
    frame, identifier = p["section3/frame"], p["section3/identifier"]
    fields, position, torque_bits = (
        p["section3/position-fields"],
        p["section3/position-bits"],
        p["section3/torque-bits"],
    )
    joints, h = p["section3/joints"], p["section3/sampling-period"]
    used = 8.0 * identifier.value + fields.value * position.value + joints.value * torque_bits.value
    rate = frame.value / 8.0 / (h.value / 1000.0)
    elements, of, share = p["section3/logic-used"], p["section3/logic-available"], p["section3/logic-share"]
    logic = 100.0 * elements.value / of.value
    memory = p["section3/memory-share"]
    bits = MEMORY_SAMPLES * joints.value * FLOAT_BITS
    percent = 100.0 * bits / DEVICE_MEMORY_BITS
    circle, tip, speed = p["section6/T2/circle"], p["section3/tip-speed"], p["section3/joint-speed"]
    reach = 100.0 * tip.value / speed.value
    return [
        Finding(
            frame.id,
            frame.place,
            "bits of a frame",
            f"8 x {identifier.printed} + {fields.printed} x {position.printed} + {joints.printed} x "
            f"{torque_bits.printed} = {used:g} of {frame.printed}",
            used,
            frame.value,
            math.nan,
            "bit",
            CONSISTENT if used <= frame.value else CONTRADICTS,
            "Two bits are left; what they hold is not printed. Read as one torque field for both joints, 13.",
            (frame.id, identifier.id, fields.id, position.id, torque_bits.id, joints.id),
        ),
        Finding(
            "section3/rate",
            "Section III",
            "rate of the serial link",
            f"{frame.printed} bit / {h.printed} ms = {rate:g} byte/s, {10.0 * rate:g} bit/s with start and stop bit",
            10.0 * rate,
            math.nan,
            math.nan,
            "bit/s",
            OPEN,
            "The paper prints no rate; 115200 bit/s carries it.",
            (frame.id, h.id),
        ),
        Finding(
            share.id,
            share.place,
            "share of the logic elements",
            f"{elements.printed} / {of.printed} = {logic:.3f} %",
            logic,
            share.value,
            share.half_step,
            "%",
            agreement(logic, share.value, share.half_step),
            "",
            (elements.id, of.id, share.id),
        ),
        Finding(
            memory.id,
            memory.place,
            "share of the memory",
            f"{MEMORY_SAMPLES} x {joints.printed} x {FLOAT_BITS} / {DEVICE_MEMORY_BITS} = {percent:.2f} %; the "
            f"difference to {memory.printed} % is {memory.value * DEVICE_MEMORY_BITS / 100.0 - bits:.0f} bits",
            percent,
            memory.value,
            memory.half_step,
            "%",
            agreement(percent, memory.value, memory.half_step, OPEN),
            "Neither the length of the stored trajectory nor the memory of the EP4CE22F17C6 (608,256 bits by its data "
            "sheet) is printed. Gains and buffers may make up the rest.",
            (memory.id, joints.id),
        ),
        Finding(
            circle.id,
            circle.place,
            "circle of T2 within the reach",
            f"{tip.printed} / {speed.printed} = {reach:.1f} cm; {circle.printed} cm is "
            f"{circle.value / reach:.3f} of it",
            circle.value,
            reach,
            math.nan,
            "cm",
            CONSISTENT if circle.value < reach else OUTSIDE,
            "Whether radius or diameter is not printed.",
            (circle.id, tip.id, speed.id),
        ),
    ]
