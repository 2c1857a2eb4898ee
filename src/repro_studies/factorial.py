"""The factorial: its cells, methods without a network, and effects of the factors; blocks are accepted experiments.

Factors of two levels: the motion of line 18, the motions of the training, the time factor of the metric in search and
scores, and the reader: Algorithm 1, or a plain network.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations, product
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from repro.config.model import Configuration
from repro.config.sections import changed
from repro.experiments.accepted import of_this_unit, read_accepted
from repro.experiments.monte_carlo import ArmScores
from repro.identification.algorithm1.search import ImageMotion
from repro.identification.least_squares import METHODS
from repro.model.parameters import Array
from repro.signals.metric import TIME_FORMULAS, MetricSettings


@dataclass(frozen=True)
class FactorialCell:
    """Levels of the factors that one network of the factorial is trained for."""

    reader: str  # "cnn" or "plain"
    motions: str  # "ideal": Eq. 10; "tracked": closed-loop motions
    image_motions: tuple[ImageMotion, ...]  # motions of line 18 that it is used with; of a plain network none


#: Networks by name. One trained on Eq. 10 alone serves both motions of line 18, which are equal there.
CELLS: dict[str, FactorialCell] = {
    "cnn-ideal": FactorialCell("cnn", "ideal", ("measured", "desired")),
    "cnn-tracked-measured": FactorialCell("cnn", "tracked", ("measured",)),
    "cnn-tracked-desired": FactorialCell("cnn", "tracked", ("desired",)),
    "plain-ideal": FactorialCell("plain", "ideal", ()),
    "plain-tracked": FactorialCell("plain", "tracked", ()),
}


def configured(config: Configuration, cell: FactorialCell, seed: int) -> Configuration:
    """Configuration that a network of the factorial is trained with."""
    data: dict[str, Any] = {"motions": cell.motions}
    if cell.reader == "plain":
        data["unmodelled"] = {"noise": config.factorial.plain.noise}
    changes = {"data": data, "training": {"seed": seed}}
    if len(cell.image_motions) == 1:
        changes["algorithm1"] = {"image_motion": cell.image_motions[0]}
    return changed(config, changes)


METRICS: dict[str, MetricSettings] = {formula: MetricSettings(formula) for formula in TIME_FORMULAS}
COLUMNS = (
    "reader", "image_motion", "training", "metric", "experiment", "training_seed", "search_seed", "id", "validation",
    "error", "met",
)  # fmt: skip


def score_references(experiments: Path, recordings: Path, config: Configuration) -> pd.DataFrame:
    """Least squares, bounded least squares and the true parameters on every block."""
    rows = []
    for block in of_this_unit(read_accepted(experiments, recordings, config), config):
        scores = ArmScores(block.recordings, config)
        estimates = {name: METHODS[name].estimate(scores.regressions[0]).beta for name in ("ordinary", "bounded")}
        for (reader, beta), metric in product([*estimates.items(), ("true", block.true)], METRICS):
            rows.append(
                {"reader": reader, "metric": metric, "experiment": block.number, **scores(beta, METRICS[metric])}
            )
    return pd.DataFrame(rows)[["reader", "metric", "experiment", "id", "validation"]]


#: Level of each factor that counts as high; an effect is high minus low.
HIGH = {"image_motion": "desired", "training": "tracked", "metric": "energy", "reader": "plain"}
#: Factors of the image CNN with Algorithm 1, and of both readers.
OF_CNN = ("image_motion", "training", "metric")
OF_BOTH = ("reader", "training", "metric")
RESPONSES = ("id", "validation", "error")


def contrast(scores: pd.DataFrame, factors: Sequence[str], effect: Sequence[str], response: str) -> pd.DataFrame:
    """Mean over the cells with a positive sign minus that over the others, of each experiment (row) and seed (column).

    A cell's sign is the product over the factors of `effect`, so that for two it is half the difference of differences.
    """
    cells = scores.groupby(["experiment", "training_seed", *factors])[response].mean().reset_index()
    sign = np.prod([np.where(cells[name] == HIGH[name], 1.0, -1.0) for name in effect], axis=0)
    sides = [cells["experiment"], cells["training_seed"], np.where(sign > 0, "plus", "minus")]
    means = cells.groupby(sides)[response].mean().unstack()
    return (means["plus"] - means["minus"]).unstack("training_seed")


def interval(values: Array) -> tuple[float, float, float]:
    """Mean of experiments (rows) crossed with training seeds (columns), and its 95 % interval.

    Both are samples: the variances of the means of rows and of columns over their numbers add up; degrees of freedom by
    Welch and Satterthwaite.
    """
    parts = [values.mean(axis=axis).var(ddof=1) / n for axis, n in ((1, len(values)), (0, values.shape[1])) if n > 1]
    freedom = [n - 1 for n in values.shape if n > 1]
    mean, variance = float(values.mean()), float(sum(parts))
    if not variance > 0:
        return mean, mean, mean
    degrees = variance**2 / sum(part**2 / f for part, f in zip(parts, freedom, strict=True))
    from scipy import stats  # noqa: PLC0415 (a quarter of a second, in each job that reads the workflow)

    half = float(stats.t.ppf(0.975, degrees) * np.sqrt(variance))
    return mean, mean - half, mean + half


def effects(scores: pd.DataFrame) -> pd.DataFrame:
    """Every main effect and interaction of two factors on the columns of `repro.experiments.networks.score_cell`.

    In column `of` ``cnn`` is Algorithm 1, ``reader`` the plain network compared with it over both motions of line 18,
    and ``reader, desired motion`` compared with its better one.
    """
    cnn = scores[scores["reader"] == "cnn"]
    plain = scores[scores["reader"] == "plain"]
    of_desired = pd.concat([cnn[cnn["image_motion"] == "desired"], plain])
    comparisons: list[tuple[str, pd.DataFrame, Sequence[str], list[tuple[str, ...]]]] = [
        ("cnn", cnn, OF_CNN, [*((name,) for name in OF_CNN), *combinations(OF_CNN, 2)]),
        ("reader", scores, OF_BOTH, [("reader",), *(("reader", name) for name in OF_BOTH[1:])]),
        ("reader, desired motion", of_desired, OF_BOTH, [("reader",)]),
    ]
    rows = []
    for of, frame, factors, chosen in comparisons:
        for effect, response in product(chosen, RESPONSES):
            if response == "error" and "metric" in effect:
                continue  # an estimate does not depend on the metric
            values = contrast(frame, factors, effect, response).to_numpy()
            rows.append((of, " x ".join(effect), response, *interval(values), *values.shape))
    columns = ("of", "effect", "response", "value", "low", "high", "experiments", "training_seeds")
    return pd.DataFrame(rows, columns=list(columns))


def cell_means(scores: pd.DataFrame, references: pd.DataFrame) -> pd.DataFrame:
    """Mean of each cell over experiments and seeds, and the methods that need no network."""
    names = ["reader", "image_motion", "training", "metric"]
    both = pd.concat([scores, references], ignore_index=True).fillna({"image_motion": "", "training": ""})
    return both.groupby(names, sort=False)[["id", "validation", "error", "met"]].mean().reset_index()
