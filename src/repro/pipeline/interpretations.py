"""Variants of the configuration for what the paper leaves open (docs/explanation)."""

import copy
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd

from repro.config import merged
from repro.pipeline.job import Config
from repro.settings import of_network


@dataclass(frozen=True)
class Variant:
    """One way to read the paper."""

    question: str  # what is left open
    name: str  # this way
    # sections and keys of the configuration that differ from the default
    change: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    network: str = "published"  # network that it starts from
    trained: bool = False  # whether it needs a network of its own
    of: str = "default"  # reading whose network it uses otherwise
    longer: int = 1  # factor on the steps of the training


#: By the name of their files; the first is what every other one is compared with.
VARIANTS: dict[str, Variant] = {
    "default": Variant("default", "as configured", trained=True),
    "omega-hertz": Variant("omega in Eq. 6 and 14", "Hz", {"signals": {"frequency_reading": "hertz"}}, trained=True),
    "omega-index": Variant(
        "omega in Eq. 6 and 14", "DCT index", {"signals": {"frequency_reading": "index"}}, trained=True
    ),
    "motion-normalised": Variant(
        "motion inside f", "divided by its maximum (Eq. 8)", {"signals": {"normalise_motion": True}}, trained=True
    ),
    "ranges-published": Variant("training ranges", "as printed", {"data": {"prior": "published"}}, trained=True),
    "label-physical": Variant("label scale", "SI units", {"data": {"label": "physical"}}, trained=True),
    "image-constant": Variant("divisor of Z1", "a constant (ours)", {"image": {"scale": "constant"}}, trained=True),
    "recipe-paper": Variant("training recipe", "the paper's schedule", network="paper-recipe", trained=True),
    "recipe-ranges": Variant(
        "training recipe",
        "the paper's schedule and ranges as printed",
        {"data": {"prior": "published"}},
        network="paper-recipe",
        trained=True,
    ),
    "desired": Variant("motion of line 18", "desired, network of Eq. 10", network="desired"),
    "tracked": Variant("training motions", "as arms track Eq. 10 (ours)", network="tracked", trained=True),
    "tracked-measured": Variant(
        "training motions", "f of the image on the measured motion", network="tracked-measured", trained=True
    ),
    "tracked-few": Variant(
        "training motions", "of 40 arms instead of 320", {"data": {"tracked": {"arms": 40}}}, "tracked", trained=True
    ),
    "tracked-unmodelled": Variant(
        "training motions",
        "with torque beyond Eq. 1",
        {"data": {"unmodelled": {"stribeck": 0.5, "ripple": 0.05, "noise": 0.03, "delay_s": 0.002}}},
        "tracked",
        trained=True,
    ),
    "tracked-constant": Variant(
        "training motions",
        "Z1 divided by a constant",
        {"image": {"scale": "constant"}},
        network="tracked",
        trained=True,
    ),
    "tracked-normalised": Variant(
        "training motions",
        "divided by its maximum (Eq. 8)",
        {"signals": {"normalise_motion": True}},
        "tracked",
        trained=True,
    ),
    "tracked-longer": Variant("training motions", "twice the steps", network="tracked", trained=True, longer=2),
    "tracked-guesses": Variant(
        "guesses of line 17",
        "up to 1, tracked motions",
        {"algorithm1": {"guess_high": 1.0}},
        network="tracked",
        of="tracked",
    ),
    "metric-energy": Variant("time factor of metr2ev", "energy ratio", {"metric": {"time_formula": "energy"}}),
    "check-definite": Variant(
        "physically possible", "positive-definite inertia", {"algorithm1": {"feasibility": "positive-definite"}}
    ),
    "limit-20": Variant("L_exe", "20 guesses", {"algorithm1": {"inner_limit": 20}}),
    "limit-1000": Variant("L_exe", "1000 guesses", {"algorithm1": {"inner_limit": 1000}}),
}


def network_files(reading: str) -> tuple[str, str]:
    """Weights and history of the network that a reading uses, below the results: the tables' own where that is it."""
    of = reading if VARIANTS[reading].trained else VARIANTS[reading].of
    owner = VARIANTS[of]
    if owner.change or owner.longer > 1:
        return f"ablation/{of}.safetensors", f"ablation/{of}.csv"
    suffix = "" if owner.network == "published" else f"-{owner.network}"
    return f"model/cnn{suffix}.safetensors", f"model/training{suffix}.csv"


def configuration_of(config: Config, reading: Variant) -> dict[str, Any]:
    """Configuration under a reading."""
    changed = copy.deepcopy(merged(of_network(config, reading.network), reading.change))
    changed["training"]["steps"] *= reading.longer
    return changed


#: What is said of the arm: the literal search on ID and T1 to T4, and on T1 to T4 what it is held against.
ARM = ("arm_id", "arm_validation", "arm_refined", "arm_least_squares", "arm_true")


def ablation_table(results: Sequence[Mapping[str, Any]], histories: Sequence[pd.DataFrame]) -> pd.DataFrame:
    """Table of all readings, in their order, from their headline numbers and their networks' histories."""
    rows = []
    for reading, result, history in zip(VARIANTS.values(), results, histories, strict=True):
        steps, loss = history[["step", "test_loss"]].iloc[-1]
        rows.append({"question": reading.question, "reading": reading.name, "steps": steps, "held_out_loss": loss})
        rows[-1] |= result
    columns = ["question", "reading", "steps", "held_out_loss", "id_mean", "id_lowest", "validation_mean"]
    table = pd.DataFrame(rows)[[*columns, *ARM]]
    return table.astype({"steps": np.int64})


#: What the figure shows of each reading.
HEADLINES = ("id_mean", "validation_mean", *ARM)


def ablation_figure(table: pd.DataFrame) -> pd.DataFrame:
    """Headline numbers in tidy form."""
    return table.melt(["question", "reading"], list(HEADLINES), "quantity", "value")
