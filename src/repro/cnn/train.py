"""Training of the CNN: fresh samples at every step (``streamed``), or the paper's own schedule (``paper``).

Budgets are steps, never seconds. The samples of a step depend on the seed and the step's number alone, so a
run that was stopped continues from its checkpoint to the same bits.
"""

import hashlib
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from repro.cnn.architecture import NetworkSettings
from repro.cnn.checkpoint import Progress, load_checkpoint, save_checkpoint
from repro.cnn.dataset import DataSettings, SampledMotion, Samples, draw_samples
from repro.cnn.factored import FactoredCNN, on_this_processor
from repro.cnn.network import sigmoid_loss
from repro.cnn.optimisers import make_optimisers
from repro.cnn.schedule import TrainingSettings, learning_rate
from repro.streams import Stream, stream

#: Share of the streamed recipe's steps in which layer 1 learns: its gradient is a third of a step, and stopping it
#: after a seventh costs next to no loss.
LEARNS_KERNELS = 0.15
#: To be counted up with what decides a run's result and is no setting.
RECIPE = 4


@dataclass(frozen=True)
class Trained:
    """A trained network and how it got there.

    Attributes
    ----------
    network : FactoredCNN
        Ready for use, in the arithmetic of its training.
    history : array of shape (rows, 4)
        Step, learning rate, mean training loss since the row before, test loss.
    seconds_at : array of shape (rows,)
        Wall time at each row of `history`, over all runs that contributed.
    """

    network: FactoredCNN
    history: NDArray[np.float64]
    seconds_at: NDArray[np.float64]


def _tensors(samples: Samples) -> tuple[Tensor, Tensor, Tensor]:
    return torch.from_numpy(samples.u), torch.from_numpy(np.array(samples.v)), torch.from_numpy(samples.residual)


def _batches(
    s: TrainingSettings, motion: SampledMotion, data: DataSettings, start: int
) -> tuple[Iterator[Samples], Samples]:
    """A batch for every step from `start`, and the test set."""
    streams = (stream(s.seed, Stream.TRAIN_STEP, step) for step in range(start, s.steps))
    if s.recipe == "streamed":
        test = draw_samples(stream(s.seed, Stream.TEST_SET), s.test_samples, motion, data)
        return (draw_samples(rng, s.batch, motion, data) for rng in streams), test
    fixed = draw_samples(stream(s.seed, Stream.FIXED_SET), s.paper.images, motion, data)
    cut = round(s.paper.train_share * s.paper.images)

    def part(index: slice | NDArray[np.int64]) -> Samples:
        return Samples(fixed.u[index], fixed.v[index], fixed.residual[index])

    return (part(rng.integers(cut, size=s.batch)) for rng in streams), part(slice(cut, None))  # with replacement


def evaluate(network: FactoredCNN, samples: Samples, batch: int = 128) -> float:
    """Mean loss over a set, in the network's arithmetic.

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
    with torch.no_grad():
        parts = [network(u[k : k + batch], v[k : k + batch]) for k in range(0, len(u), batch)]
        return float(sigmoid_loss(torch.cat(parts), residual, network.settings.sigmoid_gain))


def fingerprint(motion: SampledMotion, data: DataSettings, network: NetworkSettings, s: TrainingSettings) -> str:
    """Hash of everything that decides a run's result.

    Parameters
    ----------
    motion, data, network, s
        As for `train`.

    Returns
    -------
    str
        SHA-256, hexadecimal.
    """
    digest = hashlib.sha256(repr((RECIPE, data, network, s)).encode())
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
    settings = replace(settings, precision=on_this_processor(settings.precision))
    torch.set_deterministic_debug_mode("error")
    torch.manual_seed(settings.seed)
    net = FactoredCNN(network, settings.precision)
    if settings.recipe == "streamed":  # layers 2 and 3 begin by handing on their maps: those around them learn at once
        for kernel in (net.conv2.weight, net.conv3.weight):
            torch.nn.init.dirac_(kernel)
    optimisers = make_optimisers(net, settings, net.dtype)
    gain = 1.0 if settings.recipe == "streamed" else settings.paper.gradient_gain
    run = fingerprint(motion, data, network, settings)
    progress = load_checkpoint(checkpoint, net, optimisers, run) if checkpoint else Progress()
    batches, test = _batches(settings, motion, data, progress.step)
    began = time.perf_counter() - progress.seconds
    loss_sum, rows = progress.loss_sum, [*progress.rows]
    for step, samples in enumerate(batches, progress.step):
        rate = learning_rate(step, settings)
        for group in (g for o in optimisers for g in o.param_groups):
            group["lr"] = rate
        net.conv1.requires_grad_(settings.recipe == "paper" or step < LEARNS_KERNELS * settings.steps)
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
    return Trained(net, table[:, :4], table[:, 4])
