"""Scores of a factorial whose effects are known: a sum of main effects and interactions, the same on every block."""

import itertools

import pandas as pd

from repro.pipeline.factorial import COLUMNS, CONFIRMATION, HIGH

#: Levels of each factor, the high one last.
LEVELS = {
    "image_motion": ("measured", "desired"),
    "training": ("ideal", "tracked"),
    "omega": ("rad_per_s", "index"),
    "back_emf": (0.0, 0.34),
    "metric": ("mean-square", "energy"),
}
#: Effects on a similarity: high minus low level, and half the difference of the differences.
MAIN = {"image_motion": 0.2, "training": 0.1, "omega": -0.04, "back_emf": 0.02, "metric": -0.01}
PAIRS = {("image_motion", "training"): 0.06, ("omega", "metric"): -0.008, ("training", "back_emf"): 0.003}
#: Effect of the plain network instead of Algorithm 1, and its interaction with a factor.
READER, READER_PAIRS = 0.05, {"training": -0.02}
BLOCKS = {"1": 0.0, "2": 0.01, "3": -0.015, CONFIRMATION: 0.3}
#: Effects on the confirmation block over those on the others.
CONFIRMED = 2.0


def _sign(name, level):
    high = LEVELS[name][-1] if name == "back_emf" else HIGH[name]
    return 1.0 if level == high else -1.0


def similarity(cell, reader, scale=1.0):
    """Similarity without block effects; a plain network has no motion of line 18."""
    signs = {name: _sign(name, level) for name, level in cell.items()}
    total = sum(0.5 * MAIN[name] * sign for name, sign in signs.items())
    total += sum(0.5 * size * signs[a] * signs[b] for (a, b), size in PAIRS.items() if a in signs and b in signs)
    of_reader = 1.0 if reader == "plain" else -1.0
    total += 0.5 * READER * of_reader
    total += sum(0.5 * size * of_reader * signs[name] for name, size in READER_PAIRS.items())
    return 0.5 + scale * total


def factorial_scores(training_seeds=(1, 3), search_seeds=(1, 2), search_noise=0.001):
    """Rows as `repro.pipeline.networks.score_cell` writes them; searches differ, and their mean does not."""
    rows = []
    for reader in ("cnn", "plain"):
        factors = {name: levels for name, levels in LEVELS.items() if (reader, name) != ("plain", "image_motion")}
        for levels in itertools.product(*factors.values()):
            cell = dict(zip(factors, levels, strict=True))
            for (block, shift), seed, search in itertools.product(BLOCKS.items(), training_seeds, search_seeds):
                scale = CONFIRMED if block == CONFIRMATION else 1.0
                noise = search_noise * (search - sum(search_seeds) / len(search_seeds))
                value = similarity(cell, reader, scale) + shift + noise
                rows.append(
                    {
                        "reader": reader,
                        "image_motion": "",
                        **cell,
                        "block": block,
                        "arm": "first",
                        "training_seed": seed,
                        "search_seed": search,
                        "id": value,
                        "validation": 2.0 * value,
                        "error": 1.0 - similarity(cell | {"metric": "energy"}, reader, scale) - shift,
                        "met": 40.0 if reader == "cnn" else 0.0,
                    }
                )
    return pd.DataFrame(rows)[list(COLUMNS)]


def factorial_references():
    """Rows as `repro.pipeline.factorial.score_references` writes them."""
    names = ("omega", "back_emf", "metric")
    rows = [
        {"reader": reader, **dict(zip(names, levels, strict=True)), "block": block, "arm": "first", "id": value + shift}
        for reader, value in (("ordinary", 0.9), ("bounded", 0.85), ("true", 0.95))
        for levels in itertools.product(*(LEVELS[name] for name in names))
        for block, shift in BLOCKS.items()
    ]
    return pd.DataFrame(rows).assign(validation=lambda f: f["id"] - 0.1)
