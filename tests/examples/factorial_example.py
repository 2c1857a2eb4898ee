"""Scores of a factorial whose effects are known: a sum of main effects and interactions, equal on every experiment."""

import itertools

import numpy as np
import pandas as pd

from repro_studies.factorial import COLUMNS

#: Levels of each factor, the high one last.
LEVELS = {
    "image_motion": ("measured", "desired"),
    "training": ("ideal", "tracked"),
    "metric": ("mean-square", "energy"),
}
#: Effects on a similarity: high minus low level, and half the difference of the differences.
MAIN = {"image_motion": 0.2, "training": 0.1, "metric": -0.01}
PAIRS = {("image_motion", "training"): 0.06, ("training", "metric"): -0.008}
#: Effect of the plain network instead of Algorithm 1, and its interaction with a factor.
READER, READER_PAIRS = 0.05, {"training": -0.02}
#: Shift of every cell by the experiment.
EXPERIMENTS = {1: 0.0, 2: 0.01, 7: -0.015}


def factorial_scores():
    """Rows as `repro.experiments.networks.score_cell` writes them; searches differ, and their mean does not."""
    names = ["reader", *LEVELS, "experiment", "training_seed", "search_seed"]
    cells = itertools.product(("cnn", "plain"), *LEVELS.values(), EXPERIMENTS, (1, 3), (1, 2))
    scores = pd.DataFrame(cells, columns=names)
    # A plain network has no motion of line 18.
    scores = scores[(scores["reader"] == "cnn") | (scores["image_motion"] == "measured")].reset_index(drop=True)
    plain = scores["reader"] == "plain"
    sign = {name: np.where(scores[name] == levels[-1], 1.0, -1.0) for name, levels in LEVELS.items()}
    sign |= {"image_motion": np.where(plain, 0.0, sign["image_motion"]), "reader": np.where(plain, 1.0, -1.0)}
    known = {(name,): size for name, size in MAIN.items()} | PAIRS | {("reader",): READER}
    known |= {("reader", name): size for name, size in READER_PAIRS.items()}

    def similarity(sign):
        total = sum(0.5 * size * np.prod([sign[name] for name in names], axis=0) for names, size in known.items())
        return 0.5 + total

    shift = scores["experiment"].map(EXPERIMENTS)
    value = similarity(sign) + shift + 0.001 * (scores["search_seed"] - 1.5)
    error = 1.0 - similarity(sign | {"metric": np.ones(len(scores))}) - shift
    scores = scores.assign(id=value, validation=2.0 * value, error=error, met=np.where(plain, 0.0, 40.0))
    return scores.assign(image_motion=scores["image_motion"].mask(plain, ""))[list(COLUMNS)]


def factorial_references():
    """Rows as `repro_studies.factorial.score_references` writes them."""
    rows = [
        {"reader": reader, "metric": metric, "experiment": experiment, "id": value + shift}
        for reader, value in (("ordinary", 0.9), ("bounded", 0.85), ("true", 0.95))
        for metric in LEVELS["metric"]
        for experiment, shift in EXPERIMENTS.items()
    ]
    return pd.DataFrame(rows).assign(validation=lambda f: f["id"] - 0.1)
