"""Training of the network (Sections IV-B and V-A): its constants against each other."""

import math

from repro.paper.checks.finding import CONSISTENT, CONTRADICTS, MISPRINT, QUESTIONABLE, Finding, agreement
from repro.paper.published import Published


def training(p: Published) -> list[Finding]:
    """Split of the images, loss, learning rate, and the sizes the kernels lead to."""
    sets = p["section5a/parameter-sets"]
    found = []
    for part in ("train", "test"):
        images, share = p[f"section4b/{part}-images"], p[f"section5a/{part}-share"]
        count = share.value * sets.value / 100.0
        found.append(
            Finding(
                images.id,
                images.place,
                f"images of the {part} set",
                f"{share.printed} % of {sets.text} = {count:g}",
                count,
                images.value,
                0.0,
                "images",
                agreement(count, images.value, 0.0),
                "",
                (images.id, share.id, sets.id),
            )
        )
    return [*found, _loss(p), _learning_rate(p), _sizes(p), _labels()]


def _loss(p: Published) -> Finding:
    """The loss is called mean square error, with half its factor."""
    divisor, terms = p["section4b/loss-divisor"], p["section4b/loss-terms"]
    return Finding(
        divisor.id,
        divisor.place,
        "divisor of the mean square of the output error",
        f"a mean over {terms.printed} terms divides by {terms.printed}; printed 1/{divisor.printed} = half of it",
        terms.value,
        divisor.value,
        0.0,
        "1",
        agreement(terms.value, divisor.value, 0.0, QUESTIONABLE),
        "The formula is half the mean square, which is common; the words omit the half.",
        (divisor.id, terms.id),
    )


def _learning_rate(p: Published) -> Finding:
    """The learning rate rises with the iteration."""
    start, slope, steps = (p[f"section4b/{n}"] for n in ("learning-rate", "learning-rate-slope", "iterations"))
    end = start.value + slope.value * steps.value
    return Finding(
        slope.id,
        slope.place,
        "learning rate at the end of the training",
        f"{start.printed} + {slope.printed} x {steps.printed} = {end:.4g}",
        end,
        start.value,
        math.nan,
        "1",
        QUESTIONABLE if end > start.value else CONSISTENT,
        "It grows; a schedule usually falls. Held against its start. A minus sign may be lost in the extracted text.",
        (start.id, slope.id, steps.id),
    )


def _sizes(p: Published) -> Finding:
    """Sizes of the maps after kernels without padding and pooling in the first two layers."""
    size, pool = p["section4b/input/rows"].value, p["section4b/pool"].value
    ids = ["section4b/input/rows", "section4b/pool"]
    chain, fits = [f"{size:g}"], True
    for layer in (1, 2, 3):
        kernel = p[f"section4b/kernel{layer}/size"]
        ids.append(kernel.id)
        size = size - kernel.value + 1.0
        chain.append(f"{size:g}")
        if layer < 3:
            fits &= size % pool == 0
            size /= pool
            chain.append(f"{size:g}")
    maps = p["section4b/kernel3/outputs"]
    return Finding(
        "section4b/sizes",
        "Section IV-B",
        "kernels and pooling fit the image",
        f"{' -> '.join(chain)}; {size:g}^2 x {maps.printed} = {size**2 * maps.value:g} inputs of layer 4",
        size,
        round(size),
        0.0,
        "pixels",
        agreement(size, round(size), 0.0) if fits and size > 0 else CONTRADICTS,
        "Table 3, which lists the sizes, is lost.",
        (*ids, maps.id),
    )


def _labels() -> Finding:
    """Label of a residual of 1, sent through line 20."""
    label = 1.0 / (1.0 + math.exp(1.0))
    back = -math.log((1.0 - label) / label)
    return Finding(
        "section4b/labels",
        "Section IV-B",
        "a label, sent through line 20 of Algorithm 1, gives the residual back",
        f"y_d = [1 + exp(L)]^-1 at L = 1: {label:.4f}; -log[(1 - r)/r] of it = {back:.4f}",
        back,
        1.0,
        0.0,
        "1",
        agreement(back, 1.0, 1e-12, MISPRINT),
        "Eq. 13 has exp(-c z), and line 20 inverts it for c = 1; the label formula lacks the minus. It may be lost in "
        "the extracted text.",
    )
