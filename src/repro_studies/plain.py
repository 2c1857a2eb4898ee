"""Networks from torque to parameters, without image and guess: the ablation of Eq. 9.

They learn from the same arms and motions as the CNN, by their likelihood: an amortised posterior (Papamakarios and
Murray 2016) of the nine parameters given the 200 torque samples, normal (`PlainNetwork`) or of any shape (`Flow`).
"""

import itertools
from abc import ABC, abstractmethod
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import numpy as np
import torch
from torch import Tensor, nn

from repro.cnn.architecture import PlainSettings
from repro.cnn.dataset import DataSettings, SampledMotion, draw_torques
from repro.errors import require
from repro.files import read_tensors, write_tensors
from repro.model.parameters import NAMES, Array
from repro.streams import Stream, stream

#: Features of the torque, transforms of the flow, and the width of the two hidden layers of each.
FEATURES, TRANSFORMS, HIDDEN = 64, 3, 128
#: Parameters, and the lower triangle of the factor of their precision matrix.
_N = len(NAMES)
_LOWER = torch.tril_indices(_N, _N)


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
        self.body = _body(2 * samples, width, width, width)
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


class Flow(Posterior):
    """A neural spline flow (Durkan and others 2019) of the package zuko: a posterior of any shape."""

    def __init__(self, samples: int, width: int, mean: Array, covariance: Array) -> None:
        """Mean (9,) and covariance (9, 9) of the training arms give the range of the splines."""
        super().__init__()
        require("zuko", "flow", "study.networks: flow")
        from zuko.flows import NSF  # noqa: PLC0415  (an extra)

        self.body = _body(2 * samples, width, width).append(nn.Linear(width, FEATURES))
        self.flow = NSF(_N, FEATURES, transforms=TRANSFORMS, hidden_features=(HIDDEN, HIDDEN))
        self.centre: Tensor
        self.spread: Tensor
        self.register_buffer("centre", _tensor(mean))
        self.register_buffer("spread", _tensor(np.sqrt(np.diag(covariance))))

    def loss(self, alpha: Tensor, beta: Tensor) -> Tensor:
        """Negative log-likelihood of parameters (n, 9), without the constant of their units."""
        scaled = (beta - self.centre) / self.spread
        log_probability: Tensor = self.flow(self.body(alpha)).log_prob(scaled)
        return -log_probability.mean()

    def sample(self, alpha: Array, normal: Array) -> Array:
        """Draw parameters (n, 9) behind a torque (2, M) over its largest magnitude from normal numbers (n, 9)."""
        scaled = self.flow(self.body(_tensor(alpha.reshape(-1)))).transform.inv(_tensor(normal))
        return np.asarray((self.centre + self.spread * scaled).numpy(), dtype=np.float64)


def _body(*sizes: int) -> nn.Sequential:
    """Fully connected layers of these sizes, each with its nonlinearity."""
    layers = [(nn.Linear(a, b), nn.SiLU()) for a, b in itertools.pairwise(sizes)]
    return nn.Sequential(*itertools.chain(*layers))


def _tensor(values: Array) -> Tensor:
    return torch.from_numpy(values.astype(np.float32))


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
        loss = network.loss(_tensor(alpha.reshape(len(alpha), -1)), _tensor(beta_bar))
        loss.backward()  # type: ignore[no-untyped-call]
        nn.utils.clip_grad_norm_(network.parameters(), 10.0)
        optimiser.step()
        if (step + 1) % 50 == 0:
            report(step + 1, settings.steps)
    return network.requires_grad_(False)


def read_torque(network: PlainNetwork, alpha: Array) -> tuple[Array, Array]:
    """Mean (9,) of the parameters behind a torque (2, M) over its largest magnitude, and factor (9, 9) of precision."""
    mean, factor = network(_tensor(alpha.reshape(1, -1)))
    return mean[0].numpy().astype(np.float64), factor[0].numpy().astype(np.float64)


def save_posterior(path: Path, network: Posterior) -> None:
    """Write the weights."""
    write_tensors(path, {name: weight.numpy() for name, weight in network.state_dict().items()})


def load_posterior(path: Path, network: P) -> P:
    """Give a new network the weights that `save_posterior` wrote."""
    weights, _ = read_tensors(path, "weights of `save_posterior`")
    network.load_state_dict({name: torch.from_numpy(weight) for name, weight in weights.items()})
    return network.requires_grad_(False)
