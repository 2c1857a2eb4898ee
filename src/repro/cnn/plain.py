"""A plain network from torque to parameters: no image and no guess, the ablation of Eq. 9.

It learns from the same arms and motions as the CNN: the mean and the covariance of the nine parameters given the 200
torque samples, by the likelihood of a normal distribution (amortised Gaussian posterior, Papamakarios and Murray 2016).
"""

import itertools
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import numpy as np
import torch
from torch import Tensor, nn

from repro.cnn.dataset import DataSettings, SampledMotion, draw_torques
from repro.files import read_tensors, write_tensors
from repro.model.parameters import NAMES, Array
from repro.streams import Stream, stream

#: Parameters, and the lower triangle of the factor of their precision matrix.
_N = len(NAMES)
_LOWER = torch.tril_indices(_N, _N)


@dataclass(frozen=True)
class PlainSettings:
    """Size and budget."""

    width: int = 512  # of each of three hidden layers
    steps: int = 3000
    batch: int = 512
    learning_rate: float = 1e-3  # a cosine brings it down to zero


class Posterior(nn.Module, ABC):
    """A network that claims a distribution of the parameters behind a torque, in units of the largest torque."""

    @abstractmethod
    def loss(self, alpha: Tensor, beta: Tensor) -> Tensor:
        """Negative log-likelihood of parameters (n, 9), without its constant, of torques (n, 2 M)."""


P = TypeVar("P", bound=Posterior)


class PlainNetwork(Posterior):
    """Torque samples of both joints -> mean and precision of the parameters, in units of the largest torque."""

    def __init__(self, samples: int, width: int) -> None:
        super().__init__()
        sizes = (2 * samples, width, width, width)
        layers = [(nn.Linear(a, b), nn.SiLU()) for a, b in itertools.pairwise(sizes)]
        self.body = nn.Sequential(*(part for pair in layers for part in pair))
        self.mean = nn.Linear(width, _N)
        self.factor = nn.Linear(width, len(_LOWER[0]))
        nn.init.zeros_(self.factor.weight)
        nn.init.zeros_(self.factor.bias)

    def forward(self, alpha: Tensor) -> tuple[Tensor, Tensor]:
        """Mean (n, 9) and the lower factor L (n, 9, 9) of the precision matrix L L' of torques (n, 2 M)."""
        hidden = self.body(alpha)
        factor = hidden.new_zeros(len(alpha), _N, _N)
        factor[:, _LOWER[0], _LOWER[1]] = self.factor(hidden)
        diagonal = torch.diagonal(factor, dim1=1, dim2=2)
        return self.mean(hidden), factor - torch.diag_embed(diagonal) + torch.diag_embed(torch.exp(diagonal))

    def loss(self, alpha: Tensor, beta: Tensor) -> Tensor:
        """-log N(beta; mean, (L L')^-1), averaged over the samples, without its constant."""
        mean, factor = self(alpha)
        scaled: Tensor = (factor.transpose(1, 2) @ (beta - mean)[..., None])[..., 0]
        log_determinant = torch.log(torch.diagonal(factor, dim1=1, dim2=2)).sum(-1)
        return (0.5 * scaled.square().sum(-1) - log_determinant).mean()


def train_posterior(
    make: Callable[[int, int], P],
    motion: SampledMotion,
    data: DataSettings,
    settings: PlainSettings,
    seed: int,
    report: Callable[[int, int], None] = lambda *_: None,
) -> P:
    """Train a network, made from the number of torque samples and the width, on fresh torques at every step."""
    torch.manual_seed(seed)
    network = make(motion.torque.shape[-2], settings.width)
    optimiser = torch.optim.Adam(network.parameters(), settings.learning_rate)
    for step in range(settings.steps):
        for group in optimiser.param_groups:
            group["lr"] = 0.5 * settings.learning_rate * (1.0 + np.cos(np.pi * step / settings.steps))
        alpha, beta_bar, _ = draw_torques(stream(seed, Stream.PLAIN_STEP, step), settings.batch, motion, data)
        optimiser.zero_grad()
        inputs = torch.from_numpy(alpha.reshape(len(alpha), -1).astype(np.float32))
        loss = network.loss(inputs, torch.from_numpy(beta_bar.astype(np.float32)))
        loss.backward()  # type: ignore[no-untyped-call]
        nn.utils.clip_grad_norm_(network.parameters(), 10.0)
        optimiser.step()
        if (step + 1) % 50 == 0:
            report(step + 1, settings.steps)
    return network.requires_grad_(False)


def read_torque(network: PlainNetwork, alpha: Array) -> tuple[Array, Array]:
    """Mean (9,) of the parameters behind a torque (2, M) over its largest magnitude, and factor (9, 9) of precision."""
    mean, factor = network(torch.from_numpy(alpha.reshape(1, -1).astype(np.float32)))
    return mean[0].numpy().astype(np.float64), factor[0].numpy().astype(np.float64)


def save_posterior(path: Path, network: Posterior) -> None:
    """Write the weights."""
    write_tensors(path, {name: weight.numpy() for name, weight in network.state_dict().items()})


def load_posterior(path: Path, network: P) -> P:
    """Give a new network the weights that `save_posterior` wrote."""
    weights, _ = read_tensors(path, "weights of `save_posterior`")
    network.load_state_dict({name: torch.from_numpy(weight) for name, weight in weights.items()})
    return network.requires_grad_(False)
