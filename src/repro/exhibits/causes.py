"""Why Algorithm 1 does worse on the arm: training and motion of line 18 crossed, and the factorial of six causes."""

import numpy as np
import pandas as pd

from repro.exhibits.declare import ABLATION, EXPERIMENT, Inputs, figure, table
from repro.files import read_csv
from repro.pipeline.effects import cell_means, effects
from repro.pipeline.experiment_runs import CASE
from repro.pipeline.factorial_design import COLUMNS
from repro.pipeline.identified import read_scores
from repro.pipeline.job import Config
from repro.pipeline.summary import SCORES
from repro.render import factorial, why

#: Variants of Algorithm 1 by the motions of their training and the motion of line 18.
CAUSES = {
    "algorithm1": ("ideal", "measured"),
    "algorithm1+desired": ("ideal", "desired"),
    "algorithm1+tracked-measured": ("tracked", "measured"),
    "algorithm1+tracked": ("tracked", "desired"),
}
#: Weights of the four cells, in this order, in each effect.
EFFECTS = {
    "image_motion": (-0.5, 0.5, -0.5, 0.5),
    "training": (-0.5, -0.5, 0.5, 0.5),
    "both": (0.5, -0.5, -0.5, 0.5),
}


def crossed(scores: pd.DataFrame) -> pd.DataFrame:
    """Mean total of each seed in the four cells.

    Columns ``training, image_motion, seed, response, value``, the response being ``id`` or ``validation``.
    """
    of_causes = scores[scores["method"].isin(CAUSES)]
    on_id = of_causes["case"].eq(CASE).map({True: "id", False: "validation"}).rename("response")
    means = of_causes.groupby(["method", "seed", on_id])["total"].mean().rename("value").reset_index()
    levels = pd.DataFrame(means["method"].map(CAUSES).tolist(), columns=["training", "image_motion"], index=means.index)
    return pd.concat([levels, means[["seed", "response", "value"]]], axis=1)


def why_table(cells: pd.DataFrame) -> pd.DataFrame:
    """Mean and spread over the seeds of the four cells and of the effects, from `crossed`.

    Columns ``row, training, image_motion, response, value, spread, seeds``; an effect has its name under ``training``.
    """
    values = cells.pivot(index=["response", "seed"], columns=["training", "image_motion"], values="value")
    values = values[list(CAUSES.values())]
    effects = pd.DataFrame({name: values @ np.array(weights) for name, weights in EFFECTS.items()})
    rows: list[tuple[object, ...]] = []
    for kind, frame in (("cell", values), ("effect", effects)):
        for name in frame.columns:
            for response, of_seeds in frame[name].groupby("response"):
                where = name if kind == "cell" else (name, "")
                rows.append((kind, *where, response, of_seeds.mean(), of_seeds.std(ddof=1), len(of_seeds)))
    columns = ["row", "training", "image_motion", "response", "value", "spread", "seeds"]
    return pd.DataFrame(rows, columns=columns).fillna({"spread": 0.0})


def _factorial(inputs: Inputs) -> pd.DataFrame:
    return pd.concat([read_csv(path, COLUMNS) for path in inputs["scores"]], ignore_index=True)


@table("why", "Motions of the training and of line 18, crossed", EXPERIMENT, why.table, inputs=("arm",), trained="all")
def why_summary(inputs: Inputs, _: Config) -> pd.DataFrame:
    """Algorithm 1 on the simulated arm with two factors crossed: the motions that the network is trained on, and the
    motion on which line 18 takes f of the image.
    """
    return why_table(crossed(read_scores(inputs["scores"], SCORES)))


@figure(
    "why", "Motions of the training and of line 18, crossed", EXPERIMENT, why.figure, inputs=("arm",), trained="all"
)
def why_figure(inputs: Inputs, _: Config) -> pd.DataFrame:
    """Algorithm 1 on the simulated arm with two factors crossed: the motions that the network is trained on, and the
    motion on which line 18 takes f of the image.
    """
    return crossed(read_scores(inputs["scores"], SCORES))


@table(
    "factorial",
    "Effects of the causes",
    ABLATION,
    factorial.effects_table,
    inputs=("factorial",),
    trained="all",
    optional=True,
)
def factorial_table(inputs: Inputs, _: Config) -> pd.DataFrame:
    """Effects of six causes on the similarity that Algorithm 1 reaches on simulated arms, with 95 % intervals over
    blocks and training seeds, and the same effects on an arm that was frozen before.
    """
    return effects(_factorial(inputs))


@table(
    "factorial_cells",
    "Similarities under each combination of the causes",
    ABLATION,
    factorial.cells_table,
    label="Factorial, cells",
    target="factorial_cells",
    inputs=("factorial",),
    trained="all",
    optional=True,
)
def factorial_cells(inputs: Inputs, _: Config) -> pd.DataFrame:
    """Mean similarity on simulated arms under each combination of the causes, with methods that need no network."""
    return cell_means(_factorial(inputs), read_csv(inputs["references"][0]))


@figure(
    "factorial",
    "Effects of the causes",
    ABLATION,
    factorial.figure,
    inputs=("factorial",),
    trained="all",
    optional=True,
)
def factorial_figure(inputs: Inputs, _: Config) -> pd.DataFrame:
    """Effects of six causes on the similarity that Algorithm 1 reaches on simulated arms, with 95 % intervals over
    blocks and training seeds, and the same effects on an arm that was frozen before.
    """
    return effects(_factorial(inputs))
