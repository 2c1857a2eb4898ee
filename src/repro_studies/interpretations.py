"""Interpretations of what the paper leaves open, each as a change of the configuration (docs/explanation)."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import pandas as pd

from repro.config.model import Configuration
from repro.config.sections import changed, of_network


@dataclass(frozen=True)
class Interpretation:
    """One interpretation of the paper."""

    question: str  # what the paper leaves open
    name: str  # how this interpretation answers it
    change: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)  # of sections and keys of the configuration
    network: str = "published"  # network that it starts from
    of: str = ""  # interpretation whose network it uses, if it needs none of its own
    longer: int = 1  # factor on the steps of the training


_OMEGA, _SCHEDULE, _MOTIONS = "omega in Eq. 6 and 14", "training recipe", "training motions"
_NORMALISED = ("divided by its maximum (Eq. 8)", {"signals": {"normalise_motion": True}})
_BEYOND = {"data": {"unmodelled": {"stribeck": 0.5, "ripple": 0.05, "noise": 0.03, "delay_s": 0.002}}}
_DEFINITE = {"algorithm1": {"feasibility": "positive-definite"}}
_UP_TO_1 = {"algorithm1": {"guess_high": 1.0}}
_ENERGY = {"metric": {"time_formula": "energy"}}

#: By the name of their files; the first is what every other one is compared with.
INTERPRETATIONS: dict[str, Interpretation] = {
    "default": Interpretation("default", "as configured"),
    "omega-hertz": Interpretation(_OMEGA, "Hz", {"signals": {"frequency_reading": "hertz"}}),
    "omega-rad": Interpretation(_OMEGA, "rad/s", {"signals": {"frequency_reading": "rad_per_s"}}),
    "motion-normalised": Interpretation("motion inside f", *_NORMALISED),
    "ranges-published": Interpretation("training ranges", "as printed", {"data": {"prior": "published"}}),
    "label-physical": Interpretation("label scale", "SI units", {"data": {"label": "physical"}}),
    "image-constant": Interpretation("divisor of Z1", "a constant (ours)", {"image": {"scale": "constant"}}),
    "recipe-paper": Interpretation(_SCHEDULE, "the paper's schedule", network="paper-recipe"),
    "recipe-ranges": Interpretation(
        _SCHEDULE, "the paper's schedule and ranges as printed", network="paper-recipe-ranges"
    ),
    "desired": Interpretation("motion of line 18", "desired, network of Eq. 10", network="desired", of="default"),
    "tracked": Interpretation(_MOTIONS, "as arms track Eq. 10 (ours)", network="tracked"),
    "tracked-measured": Interpretation(_MOTIONS, "f of the image on the measured motion", network="tracked-measured"),
    "tracked-few": Interpretation(
        _MOTIONS, "of 40 arms instead of 320", {"data": {"tracked": {"arms": 40}}}, "tracked"
    ),
    "tracked-unmodelled": Interpretation(_MOTIONS, "with torque beyond Eq. 1", _BEYOND, "tracked"),
    "tracked-constant": Interpretation(
        _MOTIONS, "Z1 divided by a constant", {"image": {"scale": "constant"}}, "tracked"
    ),
    "tracked-normalised": Interpretation(_MOTIONS, *_NORMALISED, "tracked"),
    "tracked-longer": Interpretation(_MOTIONS, "twice the steps", network="tracked", longer=2),
    "tracked-guesses": Interpretation("guesses of line 17", "up to 1, tracked motions", _UP_TO_1, "tracked", "tracked"),
    "metric-energy": Interpretation("time factor of metr2ev", "energy ratio", _ENERGY, of="default"),
    "check-definite": Interpretation("physically possible", "positive-definite inertia", _DEFINITE, of="default"),
}


def network_files(name: str) -> tuple[str, str]:
    """Weights and history, below the results, of an interpretation's network: one of the tables if it is the same."""
    owner_name = INTERPRETATIONS[name].of or name
    owner = INTERPRETATIONS[owner_name]
    if owner.change or owner.longer > 1:
        return f"ablation/{owner_name}.safetensors", f"ablation/{owner_name}.csv"
    suffix = f"-{owner.network}".removesuffix("-published")
    return f"model/cnn{suffix}.safetensors", f"model/training{suffix}.csv"


def network_of_unit(unit: str, default: str) -> str:
    """Weights, below the results, of the network that is trained as configured but for the unit of omega."""
    changes = {} if unit == default else {"signals": {"frequency_reading": unit}}
    (name,) = (
        name
        for name, interpretation in INTERPRETATIONS.items()
        if interpretation.change == changes and interpretation.network == "published" and not interpretation.of
    )
    return network_files(name)[0]


def configuration_of(config: Configuration, interpretation: Interpretation) -> Configuration:
    """Configuration under an interpretation."""
    own = changed(of_network(config, interpretation.network), interpretation.change)
    return changed(own, {"training": {"steps": interpretation.longer * own.training.steps}})


#: Numbers of the arm: the literal search on ID and on T1 to T4, and the methods that it is compared with on T1 to T4.
ARM = ("arm_id", "arm_validation", "arm_refined", "arm_least_squares", "arm_true")
#: Numbers of each interpretation, and those that the figure shows.
MEASURED, HEADLINES = ("id_mean", "id_lowest", "validation_mean", *ARM), ("id_mean", "validation_mean", *ARM)


def ablation_table(results: Sequence[Mapping[str, Any]], histories: Sequence[pd.DataFrame]) -> pd.DataFrame:
    """Table of all interpretations, in their order, from their headline numbers and their networks' histories."""
    rows = []
    for interpretation, result, history in zip(INTERPRETATIONS.values(), results, histories, strict=True):
        steps, loss = history[["step", "test_loss"]].iloc[-1]
        names = {"question": interpretation.question, "reading": interpretation.name}
        rows.append({**names, "steps": int(steps), "held_out_loss": loss, **result})
    return pd.DataFrame(rows)[["question", "reading", "steps", "held_out_loss", *MEASURED]]


def ablation_figure(table: pd.DataFrame) -> pd.DataFrame:
    """Headline numbers in tidy form."""
    return table.melt(["question", "reading"], list(HEADLINES), "quantity", "value")
