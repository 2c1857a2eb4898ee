"""Sampling, encoder, serial link, device and torque (Sections III and V-C, Table 8) against each other."""

import math

from repro.paper.checks.finding import (
    CONSISTENT,
    CONTRADICTS,
    NOT_POSSIBLE,
    OPEN,
    OUTSIDE,
    QUESTIONABLE,
    Finding,
    compares,
    equals,
)
from repro.paper.published import Published
from repro.signals.programs import MEMORY_SAMPLES

#: Memory of the EP4CE22; like the length of the desired trajectory that fills it best, not printed in the paper.
DEVICE_MEMORY_BITS = 608256
FLOAT_BITS = 32


def sampling(p: Published) -> list[Finding]:
    """Check the sampling rate, and the band that 100 coefficients cover on the identification trajectory."""
    period, rate = p["section3/sampling-period"], p["section3/sampling-rate"]
    hertz = 1000.0 / period.value
    duration, bands, high = p["section4a/time-high"], p["section4a/bands"], p["section4a/band-high"]
    h, m = period.value / 1000.0, bands.value
    n = round(duration.value * math.pi / h)
    band = (m - 1.0) / (2.0 * h * n)
    wanted = (m - 1.0) / (2.0 * h * high.value)
    return [
        equals(
            rate,
            "sampling rate of the desired trajectory",
            f"1 / {period.printed} ms = {hertz:g} Hz",
            hertz,
            uses=(period, rate),
        ),
        equals(
            high,
            f"{bands.printed} bands of the DCT-II are 0 to {high.printed} Hz",
            f"N = {duration.printed} pi s / {period.printed} ms = {n}; (M - 1) / (2 h N) = {m - 1:g} / (2 x {h:g} x "
            f"{n}) = {band:.2f} Hz; {high.printed} Hz needs N = {wanted:.0f}",
            band,
            uses=(period, duration, bands, high),
            note="(M - 1) / (2 h N) is Section VI's own condition. Eq. 10 is taken to run in seconds, as printed; "
            "N = 600 would play it in 1.5 s.",
        ),
    ]


def encoder(p: Published) -> list[Finding]:
    """Check the encoder step and the position range."""
    step, gear, turns = p["section3/encoder-step"], p["section3/gear-ratio"], p["section3/position-turns"]
    low, high, bits = p["section3/position-low"], p["section3/position-high"], p["section3/position-bits"]
    # The motor's counts a turn are not printed: the whole number that the printed ones lead to.
    motor = round(2.0 * math.pi / (step.value * gear.value))
    counts = motor * gear.value
    rad = 2.0 * math.pi / counts
    span = high.value / counts
    values = high.value - low.value + 1.0
    return [
        equals(
            step,
            "resolution of the encoders",
            f"2 pi / ({step.printed} x {gear.printed}) = {2.0 * math.pi / (step.value * gear.value):.3f} counts a "
            f"motor turn, so {motor} x {gear.printed} = {counts:g} a joint turn: 2 pi / {counts:g} = {rad:.4e} rad",
            rad,
            uses=(step, gear),
            note="The counts of a motor turn are not printed; a whole number of them must give the resolution.",
        ),
        equals(
            turns,
            "range of the position register",
            f"{high.printed} / {counts:g} = {span:.4f} turns",
            span,
            uses=(turns, high, step, gear),
        ),
        equals(
            low,
            "values of the position register",
            f"{high.printed} - ({low.printed}) + 1 = {values:g} = 2^{bits.printed}",
            values,
            printed=2.0**bits.value,
            tolerance=0.0,
            unit="1",
            uses=(low, high, bits),
            note="The decoder's own register has 32 bits; a frame carries 16.",
        ),
    ]


def torque(p: Published) -> list[Finding]:
    """Check torque units, range, saturation and full torque."""
    unit, low, high = p["section3/torque-unit"], p["section3/torque-low"], p["section3/torque-high"]
    bits, motor, saturation = p["section3/torque-bits"], p["section3/motor-torque"], p["fig03/saturation/joint1"]
    percent = 100.0 / high.value
    values = high.value - low.value + 1.0
    duty = low.value * percent
    found = [
        equals(
            unit,
            "duty cycle of one torque unit",
            f"100 % / {high.printed} = {percent:.5f} %; 100 % / {high.value + 1.0:g} = "
            f"{100.0 / (high.value + 1.0):.5f} %",
            percent,
            uses=(unit, high),
            note="So full duty cycle is the largest unit, not one more.",
        ),
        equals(
            bits,
            "values of the torque register",
            f"{high.printed} - ({low.printed}) + 1 = {values:g} = 2^{bits.printed}",
            values,
            printed=2.0**bits.value,
            tolerance=0.0,
            unit="1",
            uses=(bits, low, high),
        ),
        compares(
            low,
            "lower end of the torque range, as a duty cycle",
            f"{low.printed} x {percent:.5f} % = {duty:.3f} %; Fig. 3 saturates at -{saturation.printed}",
            duty,
            -100.0,
            CONSISTENT if duty >= -100.0 else NOT_POSSIBLE,
            unit="%",
            uses=(low, high, saturation),
            note="The register can hold it, the controller never sends it.",
        ),
    ]
    for j in (1, 2):
        full, count = p[f"section5c/full-torque/joint{j}"], p[f"section5c/full-count/joint{j}"]
        found.append(
            compares(
                full,
                f"torque of joint {j} at full duty cycle within the motor's",
                f"{full.printed} N m <= {motor.printed} N m: {100.0 * full.value / motor.value:.1f} %; one unit is "
                f"{full.printed} / {count.printed} = {1e3 * full.value / count.value:.4f} mN m",
                full.value,
                motor.value,
                CONSISTENT if full.value <= motor.value else OUTSIDE,
                unit="N m",
                uses=(full, count, motor),
            )
        )
    return [*found, _velocity_gain(p)]


def _velocity_gain(p: Published) -> Finding:
    """K_v multiplies a difference of positions in Eq. 2, so its unit is that of K_p."""
    gain, h, step = p["table08/kv/joint1"], p["section3/sampling-period"], p["section3/encoder-step"]
    full = p["section5c/full-torque/joint1"]
    damping = gain.value * h.value / 1000.0
    one = gain.value * step.value
    return compares(
        gain,
        "unit of K_v: N m/rad",
        f"Eq. 2 multiplies q_i - q_(i-1), in rad: {gain.printed} N m/rad x {h.printed} ms = {damping:.4f} N m s/rad; "
        f"one encoder step makes {gain.printed} x {step.printed} = {one:.4f} N m, {100.0 * one / full.value:.0f} % of "
        f"{full.printed}",
        one,
        full.value,
        CONSISTENT if one <= full.value else QUESTIONABLE,
        unit="N m",
        uses=(gain, h, step, full),
        note="The sampling time is implicit in the value, as Section II-A says.",
    )


def link_and_device(p: Published) -> list[Finding]:
    """Check frame, rate of the serial link, logic elements, memory, and the circle of T2."""
    frame, identifier = p["section3/frame"], p["section3/identifier"]
    fields, position, bits = p["section3/position-fields"], p["section3/position-bits"], p["section3/torque-bits"]
    joints, h = p["section3/joints"], p["section3/sampling-period"]
    used = 8.0 * identifier.value + fields.value * position.value + joints.value * bits.value
    rate = frame.value / 8.0 / (h.value / 1000.0)
    elements, of, share = p["section3/logic-used"], p["section3/logic-available"], p["section3/logic-share"]
    logic = 100.0 * elements.value / of.value
    memory = p["section3/memory-share"]
    stored = MEMORY_SAMPLES * joints.value * FLOAT_BITS
    percent = 100.0 * stored / DEVICE_MEMORY_BITS
    circle, tip, speed = p["section6/T2/circle"], p["section3/tip-speed"], p["section3/joint-speed"]
    reach = 100.0 * tip.value / speed.value
    return [
        compares(
            frame,
            "bits of a frame",
            f"8 x {identifier.printed} + {fields.printed} x {position.printed} + {joints.printed} x "
            f"{bits.printed} = {used:g} of {frame.printed}",
            used,
            frame.value,
            CONSISTENT if used <= frame.value else CONTRADICTS,
            unit="bit",
            uses=(frame, identifier, fields, position, bits, joints),
            note="Two bits are left; what they hold is not printed. Read as one torque field for both joints, 13.",
        ),
        compares(
            ("section3/rate", "Section III"),
            "rate of the serial link",
            f"{frame.printed} bit / {h.printed} ms = {rate:g} byte/s, {10.0 * rate:g} bit/s with start and stop bit",
            10.0 * rate,
            math.nan,
            OPEN,
            unit="bit/s",
            uses=(frame, h),
            note="The paper prints no rate; 115200 bit/s carries it.",
        ),
        equals(
            share,
            "share of the logic elements",
            f"{elements.printed} / {of.printed} = {logic:.3f} %",
            logic,
            uses=(elements, of, share),
        ),
        equals(
            memory,
            "share of the memory",
            f"{MEMORY_SAMPLES} x {joints.printed} x {FLOAT_BITS} / {DEVICE_MEMORY_BITS} = {percent:.2f} %; the "
            f"difference to {memory.printed} % is {memory.value * DEVICE_MEMORY_BITS / 100.0 - stored:.0f} bits",
            percent,
            uses=(memory, joints),
            otherwise=OPEN,
            note="Neither the length of the stored trajectory nor the memory of the EP4CE22F17C6 (608,256 bits by its "
            "data sheet) is printed. Gains and buffers may make up the rest.",
        ),
        compares(
            circle,
            "circle of T2 within the reach",
            f"{tip.printed} / {speed.printed} = {reach:.1f} cm; {circle.printed} cm is "
            f"{circle.value / reach:.3f} of it",
            circle.value,
            reach,
            CONSISTENT if circle.value < reach else OUTSIDE,
            unit="cm",
            uses=(circle, tip, speed),
            note="Whether radius or diameter is not printed.",
        ),
    ]
