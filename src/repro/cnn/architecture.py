"""Sizes of the CNN of Fig. 7 and Table 3, settings of its training, and its trained weights as plain arrays.

Nothing here loads torch, so that a configuration is checked and a kernel drawn without it.
"""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from repro.errors import InputError
from repro.files import read_tensors

ScheduleName = Literal["streamed", "paper"]
Precision = Literal["auto", "float32", "bfloat16"]

#: Columns of the history of a training run.
HISTORY_COLUMNS = ("step", "learning_rate", "train_loss", "test_loss")


@dataclass(frozen=True)
class NetworkSettings:
    """Sizes of the network."""

    image_size: int = 100  # side of the input image
    maps: int = 10  # output maps of each convolution
    kernels: tuple[int, int, int] = (9, 5, 3)  # sides of the kernels of the three convolutions
    hidden: tuple[int, int] = (100, 50)  # widths of layers 4 and 5, which the paper's text does not give
    sigmoid_gain: float = 1.0  # c of Eq. 13

    @property
    def pooled(self) -> tuple[int, int, int]:
        """Sides of the maps after layers 1, 2 and 3; ValueError if a map does not fit its 2 x 2 pool."""
        sides = [self.image_size]
        for kernel, pool in zip(self.kernels, (2, 2, 1), strict=True):
            side = sides[-1] - kernel + 1
            if side <= 0 or side % pool:
                raise ValueError(f"kernels {self.kernels}: leave a map of side {side}, which a pool of 2 does not fit.")
            sides.append(side // pool)
        return sides[1], sides[2], sides[3]

    @property
    def weights(self) -> dict[str, tuple[int, ...]]:
        """Shape of every weight by its name: kernels (output, input, k, k), matrices (output, input), biases."""
        (k1, k2, k3), maps, (first, second) = self.kernels, self.maps, self.hidden
        shapes: dict[str, tuple[int, ...]] = {
            "conv1": (maps, 2, k1, k1),
            "conv2": (maps, maps, k2, k2),
            "conv3": (maps, maps, k3, k3),
            "fc4": (first, maps * self.pooled[2] ** 2),
            "fc5": (second, first),
            "fc6": (9, second),
        }
        weights = {f"{layer}.weight": shape for layer, shape in shapes.items()}
        return weights | {f"{layer}.bias": shape[:1] for layer, shape in shapes.items()}


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
    """Schedule and budget of a training run."""

    #: Fresh samples with Muon and a falling rate, or the paper's fixed set and descent.
    recipe: ScheduleName = "streamed"
    steps: int = 4_000  # of the optimiser
    batch: int = 64  # images in a step
    learning_rate: float = 5e-3  # peak of the streamed schedule, which falls to zero
    warmup: int = 400  # steps over which the streamed rate rises, or a quarter of all if that is less
    seed: int = 1  # of weights and samples
    test_samples: int = 1024  # size of the held-out set of the streamed schedule
    log_every: int = 500  # steps between rows of the history
    checkpoint_every: int = 500
    precision: Precision = "auto"  # of layers 1 to 4 and of Muon's wide products; auto: bfloat16 if native
    paper: PaperSchedule = field(default_factory=PaperSchedule)


def read_weights(path: Path, settings: NetworkSettings, fact: str | None = None) -> dict[str, NDArray[np.floating]]:
    """Read finite weights of the shapes ``settings.weights``; the header must state the `fact`, if there is one."""
    weights, metadata = read_tensors(path, "weights of a network")
    header, expected, shapes = [*metadata.values()], settings.weights, {name: w.shape for name, w in weights.items()}
    for name in sorted(expected | shapes):
        if expected.get(name) != shapes.get(name):
            raise InputError.at(f"{path}: {name}", shapes.get(name, "nothing"), f"shape {expected.get(name, 'none')}")
    if fact is not None and header != [fact]:
        raise InputError.at(f"{path}: header", " and ".join(header) or "nothing", f"{fact} for the requested network")
    for name, weight in weights.items():
        if not np.isfinite(weight).all():
            raise InputError.at(f"{path}: {name}", "a weight that is not finite", "finite weights")
    return weights
