"""Muon: momentum with orthogonalised steps (Jordan, "Muon: An optimizer for hidden layers", 2024)."""

import math
from collections.abc import Iterable

import torch
from torch import Tensor

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

    An odd polynomial of X is a polynomial of G = X X^T times X, so the iteration runs on the small G, in single
    precision. Only the product that forms G and the last one are as wide as X; they are in `dtype`.
    """
    x = matrix.to(dtype)
    gram = (x @ x.mT).float()  # (m, m)
    square = gram.trace().clamp(min=1e-14)  # Frobenius norm squared: no singular value of X / norm exceeds one
    return (_lift(gram / square, QUINTIC_TIMES) / square.sqrt()).to(dtype) @ x


class Muon(torch.optim.Optimizer):
    """Momentum whose steps are orthogonalised, for weights as matrices from inputs to outputs.

    The step of `torch.optim.Muon` with its learning rate matched to Adam's, for kernels too and in the arithmetic
    of the network: the library's always takes bfloat16, which most processors only emulate.
    """

    def __init__(self, weights: Iterable[Tensor], lr: float, dtype: torch.dtype) -> None:
        super().__init__(weights, {"lr": lr, "momentum": 0.95, "dtype": dtype})

    @torch.no_grad()
    def step(self, _closure: None = None) -> None:  # type: ignore[override]
        """Take one step; weights without a gradient stay."""
        for group in self.param_groups:
            for weight in (w for w in group["params"] if w.grad is not None):
                state = self.state[weight]
                if not state:
                    state["momentum"] = torch.zeros_like(weight)
                momentum = state["momentum"].lerp_(weight.grad, 1 - group["momentum"])
                ahead = weight.grad.lerp(momentum, group["momentum"]).flatten(1)  # Nesterov's look ahead
                step = orthogonalised(ahead, group["dtype"])
                weight.add_(step.view_as(weight), alpha=-0.2 * math.sqrt(max(step.shape)) * group["lr"])
