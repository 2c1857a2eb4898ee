"""Our settings, constants and arithmetic as the ledger compares them with published numbers."""

import math
from collections.abc import Sequence
from dataclasses import replace
from types import ModuleType

from repro.comparison import LEDGER
from repro.config.model import Configuration
from repro.config.sections import plain
from repro.model.parameters import NAMES
from repro.paper.claims import Basis, OurValue
from repro.paper.our_results import Values


def setting(key: str, value: float, note: str = "") -> OurValue:
    """Compare what a key of the configuration makes."""
    note = ", ".join(filter(None, (f"config/config.yaml: {key}", note)))
    return OurValue(float(value), LEDGER, strict=True, note=note)


def of_paper_recipe(config: Configuration, key: str, value: float) -> OurValue:
    """Compare a setting of the paper's own training."""
    note = "of target paper_recipe; the default network is trained by the streamed recipe"
    return replace(setting(key, value, note), unused=config.training.recipe != "paper")


def constant(module: ModuleType, value: float, note: str = "") -> OurValue:
    """Compare a constant of a module."""
    return OurValue(float(value), LEDGER, strict=True, note="; ".join(filter(None, (note, module.__name__))))


def arithmetic(value: float, note: str) -> OurValue:
    """Compare what follows from other numbers or from a definition."""
    return OurValue(float(value), LEDGER, Basis.ARITHMETIC, note=note)


def literal(ours: OurValue) -> OurValue:
    """Mark a value that is written here, so that its match asserts nothing about the program."""
    return replace(ours, literal=True)


def bench() -> OurValue:
    """Leave a number to those who have the arm."""
    return OurValue(math.nan, "", note="property of the authors' arm, board or bench")


def joints(config: Configuration) -> OurValue:
    """Number of joints."""
    return setting("arm.link_lengths_m", len(config.arm.link_lengths_m))


def sampling_period(config: Configuration) -> OurValue:
    """Sampling period, ms."""
    return setting("signals.sampling_period_s", config.signals.sampling_period_s * 1e3)


def image_samples(config: Configuration) -> OurValue:
    """Number of rows and columns of the image: samples of a signal, and bands of its DCT."""
    return setting("signals.image_samples", config.signals.image_samples)


def filter_coefficient(config: Configuration) -> OurValue:
    """c_f of the filter."""
    return setting("signals.filter_coefficient", config.signals.filter_coefficient)


def numeric_arms(config: Configuration) -> OurValue:
    """Number of arms of the numeric tests."""
    return setting("numeric.arms", len(plain(config.numeric.arms)))


def true_parameters(table: str, case: str, values: Sequence[float]) -> Values:
    """Parameters of an arm of the numeric tests."""
    arm = zip(NAMES, values, strict=True)
    return {f"{table}/{case}/true/{name}": setting(f"numeric.arms.{case}", value) for name, value in arm}


def recipe_images(config: Configuration) -> OurValue:
    """Parameter sets of the paper's own training."""
    return of_paper_recipe(config, "training.paper.images", config.training.paper.images)


def recipe_iterations(config: Configuration) -> OurValue:
    """Iterations of the paper's own training."""
    steps = config.networks.paper_recipe.training["steps"]
    return of_paper_recipe(config, "networks.paper-recipe.training.steps", steps)
