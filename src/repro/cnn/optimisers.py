"""Optimisers of the two recipes."""

from functools import partial
from typing import Any

import torch

from repro.cnn.network import SignalCNN
from repro.cnn.schedule import TrainingSettings


def make_optimisers(net: SignalCNN, s: TrainingSettings) -> list[torch.optim.Optimizer]:
    """Gradient descent for the paper's recipe; for the streamed one Muon on all weights, Adam on the biases.

    A kernel counts as the matrix from its inputs to its maps. Muon's orthogonalised steps give a lower loss than Adam
    after the same number of samples.

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
    weights = [p for p in net.parameters() if p.ndim > 1]
    matrices = [torch.nn.Parameter(w.detach().flatten(1)) for w in weights]  # the same numbers
    muon = torch.optim.Muon(matrices, lr=s.learning_rate, weight_decay=0.0, adjust_lr_fn="match_rms_adamw", ns_steps=3)
    muon.register_step_pre_hook(partial(_hand_on, list(zip(weights, matrices, strict=True))))
    biases = [p for p in net.parameters() if p.ndim == 1]
    return [torch.optim.Adam(biases, lr=s.learning_rate, betas=(0.9, 0.98), fused=True), muon]


def _hand_on(pairs: list[tuple[torch.nn.Parameter, torch.nn.Parameter]], *_: Any) -> None:  # noqa: ANN401
    """Give matrices the gradients of the weights that they are."""
    for weight, matrix in pairs:
        matrix.grad = None if weight.grad is None else weight.grad.flatten(1)
