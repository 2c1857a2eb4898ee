"""Variants of the configuration for what the paper leaves open (docs/explanation)."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import pandas as pd

from repro.config.model import Configuration
from repro.config.sections import changed, of_network


@dataclass(frozen=True)
class Variant:
    """One way to read the paper."""

    question: str  # what is left open
    name: str  # this way
    change: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)  # of sections and keys of the configuration
    network: str = "published"  # network that it starts from
    of: str = ""  # reading whose network it uses, where it needs none of its own
    longer: int = 1  # factor on the steps of the training


_OMEGA, _SCHEDULE, _MOTIONS = "omega in Eq. 6 and 14", "training recipe", "training motions"
_NORMALISED = ("divided by its maximum (Eq. 8)", {"signals": {"normalise_motion": True}})
_BEYOND = {"data": {"unmodelled": {"stribeck": 0.5, "ripple": 0.05, "noise": 0.03, "delay_s": 0.002}}}
_DEFINITE = {"algorithm1": {"feasibility": "positive-definite"}}
_UP_TO_1 = {"algorithm1": {"guess_high": 1.0}}
_ENERGY = {"metric": {"time_formula": "energy"}}

#: By the name of their files; the first is what every other one is compared with.
VARIANTS: dict[str, Variant] = {
    "default": Variant("default", "as configured"),
    "omega-hertz": Variant(_OMEGA, "Hz", {"signals": {"frequency_reading": "hertz"}}),
    "omega-rad": Variant(_OMEGA, "rad/s", {"signals": {"frequency_reading": "rad_per_s"}}),
    "motion-normalised": Variant("motion inside f", *_NORMALISED),
    "ranges-published": Variant("training ranges", "as printed", {"data": {"prior": "published"}}),
    "label-physical": Variant("label scale", "SI units", {"data": {"label": "physical"}}),
    "image-constant": Variant("divisor of Z1", "a constant (ours)", {"image": {"scale": "constant"}}),
    "recipe-paper": Variant(_SCHEDULE, "the paper's schedule", network="paper-recipe"),
    "recipe-ranges": Variant(_SCHEDULE, "the paper's schedule and ranges as printed", network="paper-recipe-ranges"),
    "desired": Variant("motion of line 18", "desired, network of Eq. 10", network="desired", of="default"),
    "tracked": Variant(_MOTIONS, "as arms track Eq. 10 (ours)", network="tracked"),
    "tracked-measured": Variant(_MOTIONS, "f of the image on the measured motion", network="tracked-measured"),
    "tracked-few": Variant(_MOTIONS, "of 40 arms instead of 320", {"data": {"tracked": {"arms": 40}}}, "tracked"),
    "tracked-unmodelled": Variant(_MOTIONS, "with torque beyond Eq. 1", _BEYOND, "tracked"),
    "tracked-constant": Variant(_MOTIONS, "Z1 divided by a constant", {"image": {"scale": "constant"}}, "tracked"),
    "tracked-normalised": Variant(_MOTIONS, *_NORMALISED, "tracked"),
    "tracked-longer": Variant(_MOTIONS, "twice the steps", network="tracked", longer=2),
    "tracked-guesses": Variant("guesses of line 17", "up to 1, tracked motions", _UP_TO_1, "tracked", "tracked"),
    "metric-energy": Variant("time factor of metr2ev", "energy ratio", _ENERGY, of="default"),
    "check-definite": Variant("physically possible", "positive-definite inertia", _DEFINITE, of="default"),
}


def network_files(reading: str) -> tuple[str, str]:
    """Weights and history of the network that a reading uses, below the results: the tables' own where that is it."""
    own = VARIANTS[reading].of or reading
    owner = VARIANTS[own]
    if owner.change or owner.longer > 1:
        return f"ablation/{own}.safetensors", f"ablation/{own}.csv"
    suffix = f"-{owner.network}".removesuffix("-published")
    return f"model/cnn{suffix}.safetensors", f"model/training{suffix}.csv"


def network_of_unit(unit: str, default: str) -> str:
    """Weights, below the results, of the network that is trained as configured but for the unit of omega."""
    changes = {} if unit == default else {"signals": {"frequency_reading": unit}}
    (reading,) = (
        name
        for name, each in VARIANTS.items()
        if each.change == changes and each.network == "published" and not each.of
    )
    return network_files(reading)[0]


def configuration_of(config: Configuration, reading: Variant) -> Configuration:
    """Configuration under a reading."""
    own = changed(of_network(config, reading.network), reading.change)
    return changed(own, {"training": {"steps": reading.longer * own.training.steps}})


#: What is reported of the arm: the literal search on ID and T1 to T4, and on T1 to T4 what it is compared with.
ARM = ("arm_id", "arm_validation", "arm_refined", "arm_least_squares", "arm_true")
#: What a reading is measured by, and what the figure shows of it.
MEASURED, HEADLINES = ("id_mean", "id_lowest", "validation_mean", *ARM), ("id_mean", "validation_mean", *ARM)


def ablation_table(results: Sequence[Mapping[str, Any]], histories: Sequence[pd.DataFrame]) -> pd.DataFrame:
    """Table of all readings, in their order, from their headline numbers and their networks' histories."""
    rows = []
    for reading, result, history in zip(VARIANTS.values(), results, histories, strict=True):
        steps, loss = history[["step", "test_loss"]].iloc[-1]
        own = {"question": reading.question, "reading": reading.name, "steps": int(steps), "held_out_loss": loss}
        rows.append({**own, **result})
    return pd.DataFrame(rows)[["question", "reading", "steps", "held_out_loss", *MEASURED]]


def ablation_figure(table: pd.DataFrame) -> pd.DataFrame:
    """Headline numbers in tidy form."""
    return table.melt(["question", "reading"], list(HEADLINES), "quantity", "value")
