"""Sizes of the CNN of Fig. 7 and Table 3, settings of its training, and its trained weights as plain arrays.

Nothing here loads torch, so that a configuration is checked and a kernel drawn without it.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar, Literal

import numpy as np
from annotated_types import Ge, Gt, Le, Lt
from numpy.typing import NDArray

from repro.errors import InputError
from repro.files import read_tensors
from repro.keys import SECTION, Count, Integer, Key, Level, Positive, Real, Seed, Whole, Width

ScheduleName = Literal["streamed", "paper"]
Precision = Literal["auto", "float32", "bfloat16"]

#: Columns of the history of a training run.
HISTORY_COLUMNS = ("step", "learning_rate", "train_loss", "test_loss")


@dataclass(frozen=True)
class NetworkSettings:
    """Sizes of the CNN."""

    __pydantic_config__ = SECTION

    image_size: ClassVar[int] = 100  # side of the input image
    maps: ClassVar[int] = 10  # output maps of each convolution
    kernels: ClassVar[tuple[int, int, int]] = (9, 5, 3)  # sides of the kernels of the three convolutions
    hidden: Annotated[tuple[Width, Width], Key("widths of layers 4 and 5", source="Table 3 (lost)")] = (100, 50)
    sigmoid_gain: Annotated[Positive, Key("c of the output's sigmoid", source="Eq. 13")] = 1.0

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
    """The paper's own training schedule."""

    __pydantic_config__ = SECTION

    images: Annotated[
        Integer, Ge(10), Le(1_000_000), Key("size of the fixed set", "images", "published: Section IV-B")
    ] = 10_000
    train_share: Annotated[
        Real,
        Gt(0),
        Lt(1),
        Key("share to train with; the rest tests", "", "published: Section IV-B", "an image at least on each side"),
    ] = 0.8
    learning_rate: Annotated[Positive, Key("eta at the first iteration", "", "published: Section IV-B")] = 20e-3
    learning_rate_slope: Annotated[
        Level, Key("what eta gains with each iteration", "1/step", "published: Section IV-B")
    ] = 0.2e-7
    gradient_gain: Annotated[Positive, Key("MT, a factor on the gradient", "", "published: Section IV-B")] = 100.0


@dataclass(frozen=True)
class TrainingSettings:
    """Training schedule and budget."""

    __pydantic_config__ = SECTION

    recipe: Annotated[
        ScheduleName,
        Key("fresh samples at every step with Muon, or the paper's schedule", source="ours; Section IV-B"),
    ] = "streamed"
    steps: Annotated[Count, Key("optimiser steps; the streamed rate ends there", "steps", "ours")] = 4_000
    batch: Annotated[Width, Key("images in a step", "images", "ours")] = 64
    learning_rate: Annotated[Positive, Key("rate, which decays linearly to zero", source="ours")] = 5e-3
    warmup: Annotated[Whole, Key("steps over which the rate rises, at most a quarter of all", "steps", "ours")] = 400
    seed: Annotated[Seed, Key("seed of weights and samples of every network, and of the examples of Fig. 8 and 9")] = 1
    test_samples: Annotated[
        Integer, Ge(1), Le(65536), Key("size of the set that is held out of the training", "images", "ours")
    ] = 1024
    log_every: Annotated[Count, Key("steps between rows of `training.csv`", "steps")] = 500
    checkpoint_every: Annotated[Count, Key("steps between checkpoints", "steps")] = 500
    #: Of layers 1 to 4 and of Muon's wide products.
    precision: Annotated[Precision, Key("arithmetic of layers 1 to 4; `auto`: bfloat16 where the processor has it")] = (
        "auto"
    )
    paper: PaperSchedule = PaperSchedule()


@dataclass(frozen=True)
class PlainSettings:
    """Size and budget of a network that reads the torque without an image."""

    __pydantic_config__ = SECTION

    width: Annotated[Width, Key("width of each of its three hidden layers")] = 512
    steps: Annotated[Count, Key("optimiser steps", "steps")] = 3000
    batch: Annotated[Width, Key("torques in a step", "torques")] = 512
    learning_rate: Annotated[Positive, Key("rate, which decays to zero as a cosine")] = 1e-3


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
