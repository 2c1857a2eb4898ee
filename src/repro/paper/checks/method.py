"""Training of the network, images and trajectories (Sections IV to VI) against each other."""

import math

import numpy as np

from repro.paper.checks.finding import (
    CONSISTENT,
    CONTRADICTS,
    MISPRINT,
    OUTSIDE,
    QUESTIONABLE,
    Finding,
    compares,
    equals,
    remark,
)
from repro.paper.published import Published


def image_and_trajectory(p: Published) -> list[Finding]:
    """Check the colour weights of Eq. 16, and the speed that Eq. 10 needs."""
    weight = p["eq16/blue/channel1"]
    blue = weight.value / 3.0 + 1.0
    speed, duration = p["section3/joint-speed"], p["section4a/time-high"]
    t = np.linspace(0.0, duration.value * math.pi, 20001)
    peaks: list[float] = []
    ids: list[str] = []
    for j, slope in ((1, np.cos(t)), (2, np.sin(t))):
        a, w, phase = (p[f"eq10/{name}/joint{j}"] for name in ("amplitude", "frequency", "phase"))
        ids += [a.id, w.id, phase.id]
        angle = w.value * t + phase.value
        second = a.value * w.value * (-np.sin(angle) if j == 1 else np.cos(angle))
        peaks.append(float(np.abs(slope + second).max()))
    return [
        compares(
            ("eq16/blue", "Eq. 16"),
            "weights of a colour",
            f"{weight.printed}/3 + 1 = {blue:.4f}; red has 2/3 + 0.7/3 = 0.9",
            blue,
            1.0,
            QUESTIONABLE if blue > 1.0 else CONSISTENT,
            unit="1",
            uses=(weight,),
            note="A colour saturates if both channels reach 1. The channels' range is not printed; a divisor of Z_DoF2 "
            "may be lost in the extracted text.",
        ),
        compares(
            ("eq10/speed", "Eq. 10"),
            "the identification trajectory stays within the joint speed",
            f"largest |dq1| = {peaks[0]:.4f}, |dq2| = {peaks[1]:.4f} rad/s; the joints reach {speed.printed} rad/s",
            max(peaks),
            speed.value,
            CONSISTENT if max(peaks) <= speed.value else OUTSIDE,
            unit="rad/s",
            uses=(speed, duration, *ids),
        ),
    ]


def random_trajectories(p: Published) -> list[Finding]:
    """Count the validation trajectories that are filtered random signals."""
    stated = p["section1a/random-trajectories"]
    return [
        remark(
            stated,
            "validation trajectories that are filtered random signals",
            f"Section I-A: {stated.printed}, a circle, a profile; Sections V-C and VI: 1 (T1), a circle, a profile, a "
            "sinusoidal trajectory",
            CONTRADICTS,
            "Figure 22, which draws them, is lost.",
            (stated,),
        )
    ]


def level_factor() -> list[Finding]:
    """Follow the factor of Eq. 15 through Algorithm 1."""
    return [
        remark(
            ("eq15/cancels", "Eq. 15, Algorithm 1"),
            "the factor of fit2trt brings a torque to the level of the training torques",
            "tau_c = c_p tau (line 6); the largest torque that line 12 divides by holds the same c_p; line 32: "
            "beta_o max(c_p tau) / (c_p max(tau_r)) = beta_o max(tau) / max(tau_r)",
            QUESTIONABLE,
            "c_p cancels: Eq. 15 and Fig. 9's mean torque affect no output of the algorithm.",
        )
    ]


def training(p: Published) -> list[Finding]:
    """Check the split of the images, loss, learning rate, and the sizes that the kernels lead to."""
    sets = p["section5a/parameter-sets"]
    found = []
    for part in ("train", "test"):
        images, share = p[f"section4b/{part}-images"], p[f"section5a/{part}-share"]
        count = share.value * sets.value / 100.0
        found.append(
            equals(
                images,
                f"images of the {part} set",
                f"{share.printed} % of {sets.text} = {count:g}",
                count,
                tolerance=0.0,
                unit="images",
                uses=(images, share, sets),
            )
        )
    return [*found, _loss(p), _learning_rate(p), _sizes(p), _labels()]


def _loss(p: Published) -> Finding:
    """The loss is called mean square error, with half its factor."""
    divisor, terms = p["section4b/loss-divisor"], p["section4b/loss-terms"]
    return equals(
        divisor,
        "divisor of the mean square of the output error",
        f"a mean over {terms.printed} terms divides by {terms.printed}; printed 1/{divisor.printed} = half of it",
        terms.value,
        tolerance=0.0,
        uses=(divisor, terms),
        otherwise=QUESTIONABLE,
        note="The formula is half the mean square, which is common; the words omit the half.",
    )


def _learning_rate(p: Published) -> Finding:
    """The learning rate rises with the iteration."""
    start, slope, steps = (p[f"section4b/{n}"] for n in ("learning-rate", "learning-rate-slope", "iterations"))
    end = start.value + slope.value * steps.value
    return compares(
        slope,
        "learning rate at the end of the training",
        f"{start.printed} + {slope.printed} x {steps.printed} = {end:.4g}",
        end,
        start.value,
        QUESTIONABLE if end > start.value else CONSISTENT,
        unit="1",
        uses=(start, slope, steps),
        note="It grows; a schedule usually falls. Held against its start. A minus sign may be lost in the extracted "
        "text.",
    )


def _sizes(p: Published) -> Finding:
    """Sizes of the maps after kernels without padding, and pooling in the first two layers."""
    side, pool = p["section4b/input/rows"], p["section4b/pool"]
    kernels = [p[f"section4b/kernel{layer}/size"] for layer in (1, 2, 3)]
    maps = p["section4b/kernel3/outputs"]
    size = side.value
    chain, fits = [f"{size:g}"], True
    for kernel in kernels:
        size = size - kernel.value + 1.0
        chain.append(f"{size:g}")
        if kernel is not kernels[-1]:
            fits &= size % pool.value == 0
            size /= pool.value
            chain.append(f"{size:g}")
    whole = fits and size > 0 and size == round(size)
    return compares(
        ("section4b/sizes", "Section IV-B"),
        "kernels and pooling fit the image",
        f"{' -> '.join(chain)}; {size:g}^2 x {maps.printed} = {size**2 * maps.value:g} inputs of layer 4",
        size,
        round(size),
        CONSISTENT if whole else CONTRADICTS,
        unit="pixels",
        tolerance=0.0,
        uses=(side, pool, *kernels, maps),
        note="Table 3, which lists the sizes, is lost.",
    )


def _labels() -> Finding:
    """Label of a residual of 1, sent through line 20."""
    label = 1.0 / (1.0 + math.exp(1.0))
    back = -math.log((1.0 - label) / label)
    return compares(
        ("section4b/labels", "Section IV-B"),
        "a label, sent through line 20 of Algorithm 1, gives the residual back",
        f"y_d = [1 + exp(L)]^-1 at L = 1: {label:.4f}; -log[(1 - r)/r] of it = {back:.4f}",
        back,
        1.0,
        MISPRINT,
        unit="1",
        tolerance=0.0,
        note="Eq. 13 has exp(-c z), and line 20 inverts it for c = 1; the label formula lacks the minus. It may be "
        "lost in the extracted text.",
    )
