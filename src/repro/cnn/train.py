"""Training of the CNN: fresh samples at every step (``streamed``), or the paper's own schedule (``paper``).

Budgets are steps, never seconds. The samples of a step depend on the seed and the step's number alone, so a
run that was stopped continues from its checkpoint to the same bits.
"""

import hashlib
import math
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from repro.cnn.checkpoint import Progress, load_checkpoint, save_checkpoint
from repro.cnn.dataset import DataSettings, SampledMotion, Samples, draw_samples
from repro.cnn.factored import DTYPES, FactoredCNN, Precision
from repro.cnn.network import NetworkSettings, SignalCNN, sigmoid_loss

Recipe = Literal["streamed", "paper"]
RECIPES: tuple[Recipe, ...] = ("streamed", "paper")

# Streams of random numbers drawn from one seed.
_TRAIN, _TEST, _FIXED = 0, 1, 2


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
        Fresh samples with Adam, Muon and a cosine schedule, or the paper's fixed set and gradient descent.
    steps : int
        Number of optimiser steps.
    batch : int
        Images in a step.
    learning_rate : float
        Peak of the streamed schedule.
    warmup : int
        Steps over which the streamed schedule rises.
    seed : int
        Seeds weights and samples.
    test_samples : int
        Size of the held-out set of the streamed recipe.
    log_every, checkpoint_every : int
        Steps between rows of the history, and between checkpoints.
    precision : {"float32", "bfloat16"}
        Arithmetic of layers 1 to 4 during training.
    paper : PaperSchedule
        Settings of the paper's recipe.
    """

    recipe: Recipe = "streamed"
    steps: int = 10_000
    batch: int = 128
    learning_rate: float = 5e-3
    warmup: int = 200
    seed: int = 1
    test_samples: int = 4096
    log_every: int = 500
    checkpoint_every: int = 500
    precision: Precision = "bfloat16"
    paper: PaperSchedule = field(default_factory=PaperSchedule)

    def __post_init__(self) -> None:
        """Refuse budgets that are not positive and unknown choices."""
        if self.recipe not in RECIPES:
            raise ValueError(f"recipe: must be one of {RECIPES}, got {self.recipe!r}.")
        if self.precision not in DTYPES:
            raise ValueError(f"precision: must be one of {tuple(DTYPES)}, got {self.precision!r}.")
        if not self.learning_rate > 0:
            raise ValueError(f"learning_rate: must be positive, got {self.learning_rate}.")
        for name in ("steps", "batch", "test_samples", "log_every", "checkpoint_every"):
            if getattr(self, name) < 1:
                raise ValueError(f"{name}: must be at least 1, got {getattr(self, name)}.")


@dataclass(frozen=True)
class Trained:
    """A trained network and how it got there.

    Attributes
    ----------
    network : FactoredCNN
        Ready for use, in single precision.
    history : array of shape (rows, 4)
        Step, learning rate, mean training loss since the row before, test loss.
    seconds : float
        Wall time spent on training, over all runs that contributed.
    seconds_at : array of shape (rows,)
        Wall time at each row of `history`.
    """

    network: FactoredCNN
    history: NDArray[np.float64]
    seconds: float
    seconds_at: NDArray[np.float64]


HISTORY_COLUMNS = ("step", "learning_rate", "train_loss", "test_loss")


def _tensors(samples: Samples) -> tuple[Tensor, Tensor, Tensor]:
    return torch.from_numpy(samples.u), torch.from_numpy(np.array(samples.v)), torch.from_numpy(samples.residual)


def _rate(step: int, s: TrainingSettings) -> float:
    """Learning rate of a step, counted from 0."""
    if s.recipe == "paper":
        return s.paper.learning_rate + s.paper.learning_rate_slope * step
    rise = min(1.0, (step + 1) / max(s.warmup, 1))
    return s.learning_rate * rise * 0.5 * (1.0 + math.cos(math.pi * step / s.steps))


def _streamed(s: TrainingSettings, motion: SampledMotion, data: DataSettings, start: int) -> Iterator[Samples]:
    """A fresh batch for every step from `start`."""
    for step in range(start, s.steps):
        yield draw_samples(np.random.default_rng((s.seed, _TRAIN, step)), s.batch, motion, data)


def _fixed(s: TrainingSettings, pool: Samples, start: int) -> Iterator[Samples]:
    """Batches drawn with replacement from the fixed training set."""
    for step in range(start, s.steps):
        pick = np.random.default_rng((s.seed, _TRAIN, step)).integers(len(pool.residual), size=s.batch)
        yield Samples(pool.u[pick], pool.v[pick], pool.residual[pick])


def _batches(
    s: TrainingSettings, motion: SampledMotion, data: DataSettings, start: int
) -> tuple[Iterator[Samples], Samples]:
    """Training batches from `start`, and the test set."""
    if s.recipe == "streamed":
        test = draw_samples(np.random.default_rng((s.seed, _TEST)), s.test_samples, motion, data)
        return _streamed(s, motion, data, start), test
    fixed = draw_samples(np.random.default_rng((s.seed, _FIXED)), s.paper.images, motion, data)
    cut = round(s.paper.train_share * s.paper.images)
    train = Samples(fixed.u[:cut], fixed.v[:cut], fixed.residual[:cut])
    return _fixed(s, train, start), Samples(fixed.u[cut:], fixed.v[cut:], fixed.residual[cut:])


def make_optimisers(net: SignalCNN, s: TrainingSettings) -> list[torch.optim.Optimizer]:
    """Gradient descent for the paper's recipe; for the streamed one Muon on the two hidden matrices, Adam elsewhere.

    Muon's orthogonalised steps give a lower loss than Adam alone after the same number of samples.

    Parameters
    ----------
    net : SignalCNN
        Network to train.
    s : TrainingSettings
        Recipe and learning rate.

    Returns
    -------
    list of torch.optim.Optimizer
        To be stepped together.
    """
    if s.recipe == "paper":
        return [torch.optim.SGD(net.parameters(), lr=s.paper.learning_rate)]
    hidden = [net.fc4.weight, net.fc5.weight]
    rest = [p for p in net.parameters() if all(p is not w for w in hidden)]
    return [
        torch.optim.Adam(rest, lr=s.learning_rate, betas=(0.9, 0.98), fused=True),
        torch.optim.Muon(hidden, lr=s.learning_rate, weight_decay=0.0, adjust_lr_fn="match_rms_adamw", ns_steps=3),
    ]


def evaluate(network: FactoredCNN, samples: Samples, batch: int = 128) -> float:
    """Mean loss over a set, in single precision.

    Parameters
    ----------
    network : FactoredCNN
        Network to test.
    samples : Samples
        Held-out samples.
    batch : int
        Images at a time.

    Returns
    -------
    float
        Loss of Section IV-B.
    """
    u, v, residual = _tensors(samples)
    precision, network.dtype = network.dtype, torch.float32
    try:
        with torch.no_grad():
            parts = [network(u[k : k + batch], v[k : k + batch]) for k in range(0, len(u), batch)]
            return float(sigmoid_loss(torch.cat(parts), residual, network.settings.sigmoid_gain))
    finally:
        network.dtype = precision


def _fingerprint(motion: SampledMotion, data: DataSettings, network: NetworkSettings, s: TrainingSettings) -> str:
    """Hash of everything that decides a run's result."""
    digest = hashlib.sha256(repr((data, network, s)).encode())
    for array in (motion.torque, motion.model):
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


def train(
    motion: SampledMotion,
    data: DataSettings,
    network: NetworkSettings,
    settings: TrainingSettings,
    checkpoint: Path | None = None,
    report: Callable[[int, int, float], None] = lambda *_: None,
) -> Trained:
    """Train the network.

    Parameters
    ----------
    motion : SampledMotion
        Regressors of the identification trajectory.
    data : DataSettings
        Distribution of the samples.
    network : NetworkSettings
        Sizes.
    settings : TrainingSettings
        Recipe and budget.
    checkpoint : Path or None
        Where to save progress; if a file of the same run is there, training continues from it.
    report : callable
        Called with steps done, steps in all and the latest training loss.

    Returns
    -------
    Trained
        Network and history.
    """
    torch.use_deterministic_algorithms(True)
    torch.manual_seed(settings.seed)
    net = FactoredCNN(network, settings.precision)
    optimisers = make_optimisers(net, settings)
    gain = 1.0 if settings.recipe == "streamed" else settings.paper.gradient_gain
    run = _fingerprint(motion, data, network, settings)
    progress = load_checkpoint(checkpoint, net, optimisers, run) if checkpoint else Progress()
    batches, test = _batches(settings, motion, data, progress.step)
    began = time.perf_counter() - progress.seconds
    loss_sum, rows = progress.loss_sum, [*progress.rows]
    for step, samples in enumerate(batches, progress.step):
        rate = _rate(step, settings)
        for group in (g for o in optimisers for g in o.param_groups):
            group["lr"] = rate
        u, v, residual = _tensors(samples)
        net.zero_grad()
        loss = sigmoid_loss(net(u, v), residual, network.sigmoid_gain)
        (gain * loss).backward()  # type: ignore[no-untyped-call]
        for optimiser in optimisers:
            optimiser.step()
        done = step + 1
        loss_sum += float(loss.detach())
        if done % settings.log_every == 0 or done == settings.steps:
            since = (done - 1) % settings.log_every + 1
            rows.append((done, rate, loss_sum / since, evaluate(net, test), time.perf_counter() - began))
            loss_sum = 0.0
        if done % 50 == 0 or done == settings.steps:
            report(done, settings.steps, float(loss.detach()))
        if checkpoint and done % settings.checkpoint_every == 0 and done < settings.steps:
            saved = Progress(done, loss_sum, time.perf_counter() - began, rows)
            save_checkpoint(checkpoint, net, optimisers, saved, run)
    table = np.array(rows, dtype=np.float64)
    net.dtype = torch.float32
    return Trained(net, table[:, :4], float(table[-1, 4]), table[:, 4])
