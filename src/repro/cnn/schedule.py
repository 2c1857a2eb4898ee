"""Settings of training: recipes and budgets; `repro.cnn.train` follows them."""

from dataclasses import dataclass, field
from typing import Literal, get_args

Recipe = Literal["streamed", "paper"]
RECIPES: tuple[Recipe, ...] = get_args(Recipe)
Precision = Literal["auto", "float32", "bfloat16"]

#: Columns of the history of a training run.
HISTORY_COLUMNS = ("step", "learning_rate", "train_loss", "test_loss")


@dataclass(frozen=True)
class PaperSchedule:
    """Section IV-B: stochastic gradient descent on a fixed set."""

    images: int = 10_000  # size of the fixed set
    train_share: float = 0.8  # fraction used for training; the rest is for testing
    learning_rate: float = 20e-3  # eta = 20e-3 + 0.2e-7 T, as printed, which grows with the iteration T
    learning_rate_slope: float = 0.2e-7
    gradient_gain: float = 100.0  # MT, a factor on the derivative of the loss


@dataclass(frozen=True)
class TrainingSettings:
    """Recipe and budget of a training run."""

    recipe: Recipe = "streamed"  # fresh samples with Muon and a falling rate, or the paper's fixed set and descent
    steps: int = 4_000  # of the optimiser
    batch: int = 64  # images in a step
    learning_rate: float = 5e-3  # peak of the streamed recipe, which falls to zero
    warmup: int = 400  # steps over which the streamed rate rises, or a quarter of all if that is less
    seed: int = 1  # of weights and samples
    test_samples: int = 1024  # size of the held-out set of the streamed recipe
    log_every: int = 500  # steps between rows of the history
    checkpoint_every: int = 500
    precision: Precision = "auto"  # of layers 1 to 4 and of Muon's wide products; auto: bfloat16 if native
    paper: PaperSchedule = field(default_factory=PaperSchedule)
