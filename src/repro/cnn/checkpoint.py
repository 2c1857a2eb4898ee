"""Weights and training state on disk, as safetensors: no pickle, whole or absent."""

import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import torch
from torch import Tensor, nn

from repro.cnn.architecture import NetworkSettings
from repro.cnn.factored import FactoredCNN, on_this_processor
from repro.cnn.schedule import Precision
from repro.cnn.weights import read_weights
from repro.files import read_tensors, write_tensors


@dataclass(frozen=True)
class Progress:
    """Where a training run stands.

    Attributes
    ----------
    step : int
        Steps done.
    loss_sum : float
        Sum of the training losses since the last row.
    seconds : float
        Wall time so far.
    rows : list of tuple
        Step, learning rate, training loss, test loss and seconds of each row of the history.
    """

    step: int = 0
    loss_sum: float = 0.0
    seconds: float = 0.0
    rows: list[tuple[float, float, float, float, float]] = field(default_factory=list)


def save_network(path: Path, network: nn.Module, metadata: dict[str, str]) -> None:
    """Write the weights.

    Parameters
    ----------
    path : Path
        Destination, ``.safetensors``.
    network : nn.Module
        Trained network.
    metadata : dict of str
        A fact kept in the file's header, one at most: several are written in any order. Nothing that changes from run
        to run belongs here.
    """
    write_tensors(path, {name: weight.numpy() for name, weight in network.state_dict().items()}, metadata)


def load_network(
    path: Path, settings: NetworkSettings, said: str | None = None, precision: Precision = "float32"
) -> FactoredCNN:
    """Read the weights into a network for inference.

    Parameters
    ----------
    path : Path
        File made by `save_network`.
    settings : NetworkSettings
        Sizes.
    said : str, optional
        The fact that the file's header must hold.
    precision : {"auto", "float32", "bfloat16"}
        Arithmetic to read images in, as for training.

    Returns
    -------
    FactoredCNN
        Without gradients.

    Raises
    ------
    InputError
        If the file is missing, damaged, another network's, or holds other sizes.
    """
    weights = read_weights(path, settings, said)
    network = FactoredCNN(settings, on_this_processor(precision))
    network.load_state_dict({name: torch.from_numpy(weight) for name, weight in weights.items()})
    return network.requires_grad_(False)


def save_checkpoint(
    path: Path, network: nn.Module, optimisers: Sequence[torch.optim.Optimizer], progress: Progress, run: str
) -> None:
    """Write weights, optimiser state and progress.

    Parameters
    ----------
    path : Path
        Destination.
    network : nn.Module
        Network being trained.
    optimisers : sequence of torch.optim.Optimizer
        Its optimisers.
    progress : Progress
        Where the run stands.
    run : str
        What identifies the run; only the same run may continue from the file.
    """
    arrays = {f"network.{name}": weight.numpy() for name, weight in network.state_dict().items()}
    for which, optimiser in enumerate(optimisers):
        for index, state in optimiser.state_dict()["state"].items():
            arrays |= {f"{which}.{index}.{key}": t.numpy() for key, t in state.items() if isinstance(t, Tensor)}
    write_tensors(path, arrays, {"progress": json.dumps(progress.__dict__), "run": run})


def load_checkpoint(path: Path, network: nn.Module, optimisers: Sequence[torch.optim.Optimizer], run: str) -> Progress:
    """Restore what `save_checkpoint` wrote, or start anew if there is no file or it is another run's.

    Parameters
    ----------
    path : Path
        File to continue from.
    network : nn.Module
        Receives the weights.
    optimisers : sequence of torch.optim.Optimizer
        Receive their states.
    run : str
        What identifies the run.

    Returns
    -------
    Progress
        Where to continue.
    """
    if not path.exists():
        return Progress()
    arrays, metadata = read_tensors(path, "a checkpoint; delete it to start anew")
    if metadata.get("run") != run:
        return Progress()
    tensors = {name: torch.from_numpy(array) for name, array in arrays.items()}
    prefix = "network."
    network.load_state_dict({n.removeprefix(prefix): t for n, t in tensors.items() if n.startswith(prefix)})
    for which, optimiser in enumerate(optimisers):
        state: dict[int, dict[str, Tensor]] = {}
        for name, tensor in tensors.items():
            owner, index, key = name.split(".")
            if owner == str(which):
                state.setdefault(int(index), {})[key] = tensor
        optimiser.load_state_dict({"state": state, "param_groups": optimiser.state_dict()["param_groups"]})
    raw = json.loads(metadata["progress"])
    return Progress(raw["step"], raw["loss_sum"], raw["seconds"], [tuple(row) for row in raw["rows"]])
