"""Recipes of training: budgets and learning rates; `repro.cnn.optimisers` takes the steps."""

from dataclasses import dataclass, field
from typing import Literal, get_args

Recipe = Literal["streamed", "paper"]
RECIPES: tuple[Recipe, ...] = get_args(Recipe)
Precision = Literal["auto", "float32", "bfloat16"]
PRECISIONS: tuple[Precision, ...] = get_args(Precision)

#: What the history of a training run holds of each of its rows.
HISTORY_COLUMNS = ("step", "learning_rate", "train_loss", "test_loss")


@dataclass(frozen=True)
class PaperSchedule:
    """Section IV-B: stochastic gradient descent on a fixed set.

    Attributes
    ----------
    images : int
        Size of the fixed set.
    train_share : float
        Share used for training; the rest is for testing.
    learning_rate, learning_rate_slope : float
        eta = 20e-3 + 0.2e-7 T, as printed, which grows with the iteration T.
    gradient_gain : float
        MT = 100, a factor on the derivative of the loss.
    """

    images: int = 10_000
    train_share: float = 0.8
    learning_rate: float = 20e-3
    learning_rate_slope: float = 0.2e-7
    gradient_gain: float = 100.0

    def __post_init__(self) -> None:
        """Refuse a set that cannot be split."""
        if self.images < 2:
            raise ValueError(f"images: must be at least 2, got {self.images}.")
        if not 1 <= round(self.train_share * self.images) < self.images:
            raise ValueError(f"train_share: must leave images to train and to test with, got {self.train_share}.")


@dataclass(frozen=True)
class TrainingSettings:
    """Budget and optimiser.

    Attributes
    ----------
    recipe : {"streamed", "paper"}
        Fresh samples with Muon and a falling rate, or the paper's fixed set and gradient descent.
    steps : int
        Number of optimiser steps.
    batch : int
        Images in a step.
    learning_rate : float
        What the streamed schedule brings down to zero.
    warmup : int
        Steps over which the streamed schedule rises, or a quarter of all where that is less.
    seed : int
        Seeds weights and samples.
    test_samples : int
        Size of the held-out set of the streamed recipe.
    log_every, checkpoint_every : int
        Steps between rows of the history, and between checkpoints.
    precision : {"auto", "float32", "bfloat16"}
        Arithmetic of layers 1 to 4 and of Muon's wide products during training; auto takes bfloat16 where the
        processor has it.
    paper : PaperSchedule
        Settings of the paper's recipe.
    """

    recipe: Recipe = "streamed"
    steps: int = 4_000
    batch: int = 64
    learning_rate: float = 5e-3
    warmup: int = 400
    seed: int = 1
    test_samples: int = 1024
    log_every: int = 500
    checkpoint_every: int = 500
    precision: Precision = "auto"
    paper: PaperSchedule = field(default_factory=PaperSchedule)

    def __post_init__(self) -> None:
        """Refuse budgets that are not positive and unknown choices."""
        if self.recipe not in RECIPES:
            raise ValueError(f"recipe: must be one of {RECIPES}, got {self.recipe!r}.")
        if self.precision not in PRECISIONS:
            raise ValueError(f"precision: must be one of {PRECISIONS}, got {self.precision!r}.")
        if not self.learning_rate > 0:
            raise ValueError(f"learning_rate: must be positive, got {self.learning_rate}.")
        for name in ("steps", "batch", "test_samples", "log_every", "checkpoint_every"):
            if getattr(self, name) < 1:
                raise ValueError(f"{name}: must be at least 1, got {getattr(self, name)}.")


def learning_rate(step: int, s: TrainingSettings) -> float:
    """Learning rate of a step.

    Parameters
    ----------
    step : int
        Steps done before it.
    s : TrainingSettings
        Recipe and budget.

    Returns
    -------
    float
        eta of Section IV-B for the paper's recipe; a line to zero after a short rise for the streamed one.
    """
    if s.recipe == "paper":
        return s.paper.learning_rate + s.paper.learning_rate_slope * step
    rise = min(1.0, (step + 1) / max(min(s.warmup, s.steps // 4), 1))
    return s.learning_rate * rise * (1.0 - step / s.steps)
