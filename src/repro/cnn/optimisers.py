"""Optimisers of the two recipes."""

import torch

from repro.cnn.network import SignalCNN
from repro.cnn.schedule import TrainingSettings


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
