"""A normalizing flow from torque to parameters: a posterior of any shape, where that of `repro.cnn.plain` is normal.

A neural spline flow (Durkan and others 2019) of the package zuko, the extra `flow`, on features of the torque samples.
"""

import numpy as np
import torch
from torch import Tensor, nn

from repro.cnn.plain import Posterior
from repro.errors import require
from repro.model.parameters import NAMES, Array

#: Features of the torque, transforms of the flow, and the width of the two hidden layers of each.
FEATURES, TRANSFORMS, HIDDEN = 64, 3, 128


class Flow(Posterior):
    """Distribution of the parameters, in units of the largest torque, given the torque samples of both joints."""

    def __init__(self, samples: int, width: int, mean: Array, covariance: Array) -> None:
        """Mean (9,) and covariance (9, 9) of the training arms give the range of the splines."""
        super().__init__()
        require("zuko", "flow", "study.networks: flow")
        from zuko.flows import NSF  # noqa: PLC0415  (an extra)

        self.body = nn.Sequential(
            nn.Linear(2 * samples, width), nn.SiLU(), nn.Linear(width, width), nn.SiLU(), nn.Linear(width, FEATURES)
        )
        self.flow = NSF(len(NAMES), FEATURES, transforms=TRANSFORMS, hidden_features=(HIDDEN, HIDDEN))
        self.centre: Tensor
        self.spread: Tensor
        self.register_buffer("centre", torch.from_numpy(mean.astype(np.float32)))
        self.register_buffer("spread", torch.from_numpy(np.sqrt(np.diag(covariance)).astype(np.float32)))

    def loss(self, alpha: Tensor, beta: Tensor) -> Tensor:
        """Negative log-likelihood of parameters (n, 9), without the constant of their units."""
        scaled = (beta - self.centre) / self.spread
        log_probability: Tensor = self.flow(self.body(alpha)).log_prob(scaled)
        return -log_probability.mean()

    def sample(self, alpha: Array, normal: Array) -> Array:
        """Draw parameters (n, 9) behind a torque (2, M) over its largest magnitude from normal numbers (n, 9)."""
        features = self.body(torch.from_numpy(alpha.reshape(-1).astype(np.float32)))
        scaled = self.flow(features).transform.inv(torch.from_numpy(normal.astype(np.float32)))
        return np.asarray((self.centre + self.spread * scaled).numpy(), dtype=np.float64)
