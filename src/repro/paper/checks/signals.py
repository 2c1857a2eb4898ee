"""Sampling, frequency band, colours and trajectories (Sections III to VI) against each other."""

import math

import numpy as np

from repro.paper.checks.finding import CONSISTENT, CONTRADICTS, OUTSIDE, QUESTIONABLE, Finding, agreement, remark
from repro.paper.published import Published


def sampling(p: Published) -> list[Finding]:
    """Sampling rate, and the band that 100 coefficients hold on the identification trajectory."""
    period, rate = p["section3/sampling-period"], p["section3/sampling-rate"]
    hertz = 1000.0 / period.value
    duration, bands, high = p["section4a/time-high"], p["section4a/bands"], p["section4a/band-high"]
    h, m = period.value / 1000.0, bands.value
    n = round(duration.value * math.pi / h)
    band = (m - 1.0) / (2.0 * h * n)
    wanted = (m - 1.0) / (2.0 * h * high.value)
    return [
        Finding(
            rate.id,
            rate.place,
            "sampling rate of the desired trajectory",
            f"1 / {period.printed} ms = {hertz:g} Hz",
            hertz,
            rate.value,
            rate.half_step,
            "Hz",
            agreement(hertz, rate.value, rate.half_step),
            "",
            (period.id, rate.id),
        ),
        Finding(
            high.id,
            high.place,
            f"{bands.printed} bands of the DCT-II are 0 to {high.printed} Hz",
            f"N = {duration.printed} pi s / {period.printed} ms = {n}; (M - 1) / (2 h N) = {m - 1:g} / (2 x {h:g} x "
            f"{n}) = {band:.2f} Hz; {high.printed} Hz needs N = {wanted:.0f}",
            band,
            high.value,
            high.half_step,
            "Hz",
            agreement(band, high.value, high.half_step),
            "(M - 1) / (2 h N) is Section VI's own condition. Eq. 10 is taken to run in seconds, as printed; N = 600 "
            "would play it in 1.5 s.",
            (period.id, duration.id, bands.id, high.id),
        ),
    ]


def image_and_trajectory(p: Published) -> list[Finding]:
    """Colour weights of Eq. 16, and the speed that Eq. 10 asks for."""
    weight = p["eq16/blue/channel1"]
    blue = weight.value / 3.0 + 1.0
    speed = p["section3/joint-speed"]
    t = np.linspace(0.0, p["section4a/time-high"].value * math.pi, 20001)
    peaks: list[float] = []
    ids: list[str] = []
    for j, slope in ((1, np.cos(t)), (2, np.sin(t))):
        a, w, phase = (p[f"eq10/{name}/joint{j}"] for name in ("amplitude", "frequency", "phase"))
        ids += [a.id, w.id, phase.id]
        angle = w.value * t + phase.value
        second = a.value * w.value * (-np.sin(angle) if j == 1 else np.cos(angle))
        peaks.append(float(np.abs(slope + second).max()))
    return [
        Finding(
            "eq16/blue",
            "Eq. 16",
            "weights of a colour",
            f"{weight.printed}/3 + 1 = {blue:.4f}; red has 2/3 + 0.7/3 = 0.9",
            blue,
            1.0,
            math.nan,
            "1",
            QUESTIONABLE if blue > 1.0 else CONSISTENT,
            "A colour saturates if both channels reach 1. The channels' range is not printed; a divisor of Z_DoF2 may "
            "be lost in the extracted text.",
            (weight.id,),
        ),
        Finding(
            "eq10/speed",
            "Eq. 10",
            "the identification trajectory stays within the joint speed",
            f"largest |dq1| = {peaks[0]:.4f}, |dq2| = {peaks[1]:.4f} rad/s; the joints reach {speed.printed} rad/s",
            max(peaks),
            speed.value,
            math.nan,
            "rad/s",
            CONSISTENT if max(peaks) <= speed.value else OUTSIDE,
            "",
            (speed.id, "section4a/time-high", *ids),
        ),
    ]


def random_trajectories(p: Published) -> list[Finding]:
    """How many of the validation trajectories are filtered random signals."""
    stated = p["section1a/random-trajectories"]
    return [
        remark(
            stated.id,
            stated.place,
            "validation trajectories that are filtered random signals",
            f"Section I-A: {stated.printed}, a circle, a profile; Sections V-C and VI: 1 (T1), a circle, a profile, a "
            "sinusoidal trajectory",
            CONTRADICTS,
            "Figure 22, which draws them, is lost.",
            (stated.id,),
        )
    ]


def level_factor(_: Published) -> list[Finding]:
    """What Eq. 15 does to the result of Algorithm 1."""
    return [
        remark(
            "eq15/cancels",
            "Eq. 15, Algorithm 1",
            "the factor of fit2trt brings a torque to the level of the training torques",
            "tau_c = c_p tau (line 6); the largest torque that line 12 divides by holds the same c_p; line 32: "
            "beta_o max(c_p tau) / (c_p max(tau_r)) = beta_o max(tau) / max(tau_r)",
            QUESTIONABLE,
            "c_p cancels: Eq. 15 and Fig. 9's mean torque affect no output of the algorithm.",
        )
    ]
