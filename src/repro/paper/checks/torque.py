"""Torque units, range and gains (Section III, Section V-C, Table 8) against each other."""

import math

from repro.paper.checks.finding import CONSISTENT, NOT_POSSIBLE, OUTSIDE, QUESTIONABLE, Finding, agreement
from repro.paper.published import Published


def torque(p: Published) -> list[Finding]:
    """Torque units, range, saturation and full torque."""
    unit, low, high = p["section3/torque-unit"], p["section3/torque-low"], p["section3/torque-high"]
    bits, motor = p["section3/torque-bits"], p["section3/motor-torque"]
    percent = 100.0 / high.value
    values = high.value - low.value + 1.0
    duty = low.value * percent
    found = [
        Finding(
            unit.id,
            unit.place,
            "duty cycle of one torque unit",
            f"100 % / {high.printed} = {percent:.5f} %; 100 % / {high.value + 1.0:g} = "
            f"{100.0 / (high.value + 1.0):.5f} %",
            percent,
            unit.value,
            unit.half_step,
            "%",
            agreement(percent, unit.value, unit.half_step),
            "So full duty cycle is the largest unit, not one more.",
            (unit.id, high.id),
        ),
        Finding(
            bits.id,
            bits.place,
            "values of the torque register",
            f"{high.printed} - ({low.printed}) + 1 = {values:g} = 2^{bits.printed}",
            values,
            2.0**bits.value,
            0.0,
            "1",
            agreement(values, 2.0**bits.value, 0.0),
            "",
            (bits.id, low.id, high.id),
        ),
        Finding(
            low.id,
            low.place,
            "lower end of the torque range, as a duty cycle",
            f"{low.printed} x {percent:.5f} % = {duty:.3f} %; Fig. 3 saturates at "
            f"-{p['fig03/saturation/joint1'].printed}",
            duty,
            -100.0,
            math.nan,
            "%",
            CONSISTENT if duty >= -100.0 else NOT_POSSIBLE,
            "The register can hold it, the controller never sends it.",
            (low.id, high.id, "fig03/saturation/joint1"),
        ),
    ]
    for j in (1, 2):
        full, count = p[f"section5c/full-torque/joint{j}"], p[f"section5c/full-count/joint{j}"]
        found.append(
            Finding(
                full.id,
                full.place,
                f"torque of joint {j} at full duty cycle within the motor's",
                f"{full.printed} N m <= {motor.printed} N m: {100.0 * full.value / motor.value:.1f} %; one unit is "
                f"{full.printed} / {count.printed} = {1e3 * full.value / count.value:.4f} mN m",
                full.value,
                motor.value,
                math.nan,
                "N m",
                CONSISTENT if full.value <= motor.value else OUTSIDE,
                "",
                (full.id, count.id, motor.id),
            )
        )
    return [*found, _gain(p)]


def _gain(p: Published) -> Finding:
    """K_v multiplies a difference of positions in Eq. 2, so its unit is that of K_p."""
    gain, h, step = p["table08/kv/joint1"], p["section3/sampling-period"], p["section3/encoder-step"]
    full = p["section5c/full-torque/joint1"]
    damping = gain.value * h.value / 1000.0
    one = gain.value * step.value
    return Finding(
        gain.id,
        gain.place,
        "unit of K_v: N m/rad",
        f"Eq. 2 multiplies q_i - q_(i-1), in rad: {gain.printed} N m/rad x {h.printed} ms = {damping:.4f} N m s/rad; "
        f"one encoder step makes {gain.printed} x {step.printed} = {one:.4f} N m, {100.0 * one / full.value:.0f} % of "
        f"{full.printed}",
        one,
        full.value,
        math.nan,
        "N m",
        CONSISTENT if one <= full.value else QUESTIONABLE,
        "The sampling time is implicit in the value, as Section II-A says.",
        (gain.id, h.id, step.id, full.id),
    )
