"""Trained weights as plain arrays: what is drawn from them needs no network."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from repro.cnn.architecture import NetworkSettings
from repro.errors import InputError
from repro.files import read_tensors


def read_weights(path: Path, settings: NetworkSettings, said: str | None = None) -> dict[str, NDArray[np.floating]]:
    """Read the weights of a network.

    Parameters
    ----------
    path : Path
        File made by `repro.cnn.checkpoint.save_network`.
    settings : NetworkSettings
        Sizes.
    said : str, optional
        What the file's header must say of the network.

    Returns
    -------
    dict
        Weights by name, of the shapes ``settings.weights``.

    Raises
    ------
    InputError
        If the file is missing, damaged, another network's, or holds other sizes or a value that is not finite.
    """
    weights, metadata = read_tensors(path, "weights of a network")
    header = [*metadata.values()]
    wanted, found = settings.weights, {name: w.shape for name, w in weights.items()}
    if wanted != found:
        wrong = sorted(n for n in wanted.keys() | found.keys() if wanted.get(n) != found.get(n))[0]
        raise InputError.at(f"{path}: {wrong}", found.get(wrong, "nothing"), f"shape {wanted.get(wrong, 'none')}")
    if said is not None and header != [said]:
        raise InputError.at(f"{path}: header", " and ".join(header) or "nothing", f"{said}, of the network asked for")
    for name, weight in weights.items():
        if not np.isfinite(weight).all():
            raise InputError.at(f"{path}: {name}", "a weight that is not finite", "finite weights")
    return weights
