"""Training of the CNN: fresh samples at every step (``streamed``), or the paper's own schedule (``paper``).

Budgets are steps, never seconds. The samples of a step depend on the seed and the step's number alone, so a
run that was stopped continues from its checkpoint to the same bits.
"""

import hashlib
import json
import math
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path

import numpy as np
import pandas as pd
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from repro.cnn.architecture import HISTORY_COLUMNS, NetworkSettings, TrainingSettings
from repro.cnn.dataset import DataSettings, SampledMotion, Samples, draw_samples
from repro.cnn.network import FactoredCNN, on_this_processor, sigmoid_loss
from repro.files import read_tensors, write_tensors
from repro.streams import Stream, stream

#: Fraction of streamed steps in which layer 1 learns: later its gradient, a third of a step, hardly lowers the loss.
LAYER1_FRACTION = 0.15
#: Version of the training code, to increase when a change outside the settings alters results: it refuses checkpoints.
TRAINING_VERSION = 4
#: a, b, c of p(x) = x (a + b x^2 + c x^4): applied three times it lifts singular values from 0.02 on to 0.7 to 1.2.
QUINTIC = (3.4445, -4.7750, 2.0315)
QUINTIC_TIMES = 3


def _lift(gram: Tensor, times: int) -> Tensor:
    """Compute Q(G) such that p, applied so many times to X, is Q(G) X."""
    a, b, c = QUINTIC
    factor = torch.addmm(gram, gram, gram, beta=b, alpha=c)
    factor.diagonal().add_(a)
    return factor if times == 1 else _lift(factor @ gram @ factor, times - 1) @ factor


def orthogonalised(matrix: Tensor, dtype: torch.dtype) -> Tensor:
    """Bring the singular values of a matrix (m, n) near one and keep its singular vectors; quickest with m <= n.

    An odd polynomial of X is a polynomial of G = X X^T times X. The iteration runs on the small G in single precision;
    only the two products as wide as X are in `dtype`.
    """
    x = matrix.to(dtype)
    gram = (x @ x.mT).float()  # (m, m)
    square = gram.trace().clamp(min=1e-14)  # Frobenius norm squared: no singular value of X / norm exceeds one
    return (_lift(gram / square, QUINTIC_TIMES) / square.sqrt()).to(dtype) @ x


class Muon(torch.optim.Optimizer):
    """`torch.optim.Muon` with the learning rate matched to Adam's, also for kernels and in single precision."""

    def __init__(self, weights: Iterable[Tensor], lr: float, dtype: torch.dtype) -> None:
        super().__init__(weights, {"lr": lr, "momentum": 0.95, "dtype": dtype})

    @torch.no_grad()
    def step(self, _closure: None = None) -> None:  # type: ignore[override]
        """Take one step; weights without a gradient stay."""
        for group in self.param_groups:
            for weight in (w for w in group["params"] if w.grad is not None):
                momentum = self.state[weight].setdefault("momentum", torch.zeros_like(weight))
                momentum.lerp_(weight.grad, 1 - group["momentum"])
                ahead = weight.grad.lerp(momentum, group["momentum"]).flatten(1)  # Nesterov's look ahead
                step = orthogonalised(ahead, group["dtype"])
                weight.add_(step.view_as(weight), alpha=-0.2 * math.sqrt(max(step.shape)) * group["lr"])


@dataclass(frozen=True)
class Schedule:
    """A way of training: everything that the streamed and the paper's schedule do differently."""

    optimisers: list[torch.optim.Optimizer]  # to be stepped together
    rate: Callable[[int], float]  # learning rate of a step
    batch: Callable[[int], Samples]  # training samples of a step
    test: Samples
    gradient_gain: float  # factor on the derivative of the loss
    layer1_steps: float  # steps in which layer 1 learns


def paper_schedule(net: FactoredCNN, motion: SampledMotion, data: DataSettings, s: TrainingSettings) -> Schedule:
    """Gradient descent on a fixed set, from which batches are drawn with replacement (Section IV-B)."""
    fixed = draw_samples(stream(s.seed, Stream.FIXED_SET), s.paper.images, motion, data)
    cut = round(s.paper.train_share * s.paper.images)

    def part(index: slice | NDArray[np.int64]) -> Samples:
        return Samples(fixed.u[index], fixed.v[index], fixed.residual[index])

    return Schedule(
        [torch.optim.SGD(net.parameters(), lr=s.paper.learning_rate)],
        lambda step: s.paper.learning_rate + s.paper.learning_rate_slope * step,
        lambda step: part(stream(s.seed, Stream.TRAIN_STEP, step).integers(cut, size=s.batch)),
        part(slice(cut, None)),
        s.paper.gradient_gain,
        np.inf,
    )


def streamed_schedule(net: FactoredCNN, motion: SampledMotion, data: DataSettings, s: TrainingSettings) -> Schedule:
    """Fresh samples at every step; Muon on the weights (lower loss than Adam), Adam on the biases."""
    # Layers 2 and 3 start as the identity, so that all layers learn at once.
    for kernel in (net.conv2.weight, net.conv3.weight):
        nn.init.dirac_(kernel)
    weights, biases = ([p for p in net.parameters() if (p.ndim > 1) == wide] for wide in (True, False))
    adam = torch.optim.Adam(biases, lr=s.learning_rate, betas=(0.9, 0.98), fused=True)
    warmup = max(min(s.warmup, s.steps // 4), 1)
    return Schedule(
        [adam, Muon(weights, s.learning_rate, net.dtype)],
        lambda step: s.learning_rate * min(1.0, (step + 1) / warmup) * (1.0 - step / s.steps),
        lambda step: draw_samples(stream(s.seed, Stream.TRAIN_STEP, step), s.batch, motion, data),
        draw_samples(stream(s.seed, Stream.TEST_SET), s.test_samples, motion, data),
        1.0,
        LAYER1_FRACTION * s.steps,
    )


def _tensors(samples: Samples) -> tuple[Tensor, Tensor, Tensor]:
    return torch.from_numpy(samples.u), torch.from_numpy(np.array(samples.v)), torch.from_numpy(samples.residual)


def evaluate(network: FactoredCNN, samples: Samples, batch: int = 128) -> float:
    """Compute the mean loss of Section IV-B over a set, in the network's arithmetic, `batch` images at a time."""
    u, v, residual = _tensors(samples)
    with torch.no_grad():
        parts = [network(u[k : k + batch], v[k : k + batch]) for k in range(0, len(u), batch)]
        return float(sigmoid_loss(torch.cat(parts), residual, network.settings.sigmoid_gain))


def fingerprint(motion: SampledMotion, data: DataSettings, network: NetworkSettings, s: TrainingSettings) -> str:
    """Hash everything that decides the result of a run: SHA-256, hexadecimal."""
    digest = hashlib.sha256(repr((TRAINING_VERSION, data, network, s)).encode())
    columns = vars(motion.unmodelled).values() if motion.unmodelled else ()
    for array in (motion.torque, motion.model, *columns):
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


def train(
    motion: SampledMotion,
    data: DataSettings,
    network: NetworkSettings,
    settings: TrainingSettings,
    checkpoint: Path | None = None,
    report: Callable[[int, int, float], None] = lambda *_: None,
) -> tuple[FactoredCNN, pd.DataFrame]:
    """Train the network, or go on from the checkpoint of the same run; `report` gets steps, all steps and the loss.

    The history has `HISTORY_COLUMNS`, its training loss the mean since the last row, and the seconds of all runs.
    """
    settings = replace(settings, precision=on_this_processor(settings.precision))
    torch.set_deterministic_debug_mode("error")
    torch.manual_seed(settings.seed)
    net = FactoredCNN(network, settings.precision)
    schedule = (paper_schedule if settings.recipe == "paper" else streamed_schedule)(net, motion, data, settings)
    run = fingerprint(motion, data, network, settings)
    progress = load_checkpoint(checkpoint, net, schedule.optimisers, run) if checkpoint else Progress()
    began = time.perf_counter() - progress.seconds
    loss_sum, rows = progress.loss_sum, progress.rows
    for step in range(progress.step, settings.steps):
        done, rate = step + 1, schedule.rate(step)
        net.conv1.requires_grad_(step < schedule.layer1_steps)
        u, v, residual = _tensors(schedule.batch(step))
        net.zero_grad()
        loss = sigmoid_loss(net(u, v), residual, network.sigmoid_gain)
        (schedule.gradient_gain * loss).backward()  # type: ignore[no-untyped-call]
        for optimiser in schedule.optimisers:
            for group in optimiser.param_groups:
                group["lr"] = rate
            optimiser.step()
        loss_sum += float(loss.detach())
        if done % settings.log_every == 0 or done == settings.steps:
            since = (done - 1) % settings.log_every + 1
            rows.append((done, rate, loss_sum / since, evaluate(net, schedule.test), time.perf_counter() - began))
            loss_sum = 0.0
        if done % 50 == 0 or done == settings.steps:
            report(done, settings.steps, float(loss.detach()))
        if checkpoint and done % settings.checkpoint_every == 0 and done < settings.steps:
            saved = Progress(done, loss_sum, time.perf_counter() - began, rows)
            save_checkpoint(checkpoint, net, schedule.optimisers, saved, run)
    table = pd.DataFrame(np.array(rows, dtype=np.float64), columns=[*HISTORY_COLUMNS, "seconds"])
    return net, table.astype({"step": int})


@dataclass(frozen=True)
class Progress:
    """State of a training run, without its weights and optimisers."""

    step: int = 0  # steps done
    loss_sum: float = 0.0  # of the training losses since the last row
    seconds: float = 0.0  # wall time so far
    rows: list[Sequence[float]] = field(default_factory=list)  # of the history, with seconds at the end


def save_checkpoint(
    path: Path, network: nn.Module, optimisers: Sequence[torch.optim.Optimizer], progress: Progress, run: str
) -> None:
    """Write weights, optimiser states and progress as safetensors; only the run of this name may continue from them."""
    states = {"network": network.state_dict()}
    for k, optimiser in enumerate(optimisers):
        states |= {f"{k}/{index}": state for index, state in optimiser.state_dict()["state"].items()}
    arrays = {f"{part}/{key}": value.numpy() for part, state in states.items() for key, value in state.items()}
    write_tensors(path, arrays, {"progress": json.dumps(asdict(progress)), "training": run})


def load_checkpoint(path: Path, network: nn.Module, optimisers: Sequence[torch.optim.Optimizer], run: str) -> Progress:
    """Restore what `save_checkpoint` wrote; start from the beginning if there is no file or it is of another run."""
    if not path.exists():
        return Progress()
    arrays, header = read_tensors(path, "a checkpoint; delete it to start anew")
    if header.get("training") != run:
        return Progress()
    states: dict[str, dict[str, Tensor]] = {}  # by the part of the name before the last stroke
    for name, array in arrays.items():
        part, _, key = name.rpartition("/")
        states.setdefault(part, {})[key] = torch.from_numpy(array)
    network.load_state_dict(states.pop("network"))
    for k, optimiser in enumerate(optimisers):
        state = {int(part.split("/")[1]): values for part, values in states.items() if part.startswith(f"{k}/")}
        optimiser.load_state_dict({"state": state, "param_groups": optimiser.state_dict()["param_groups"]})
    return Progress(**json.loads(header["progress"]))
