"""Files of networks: their configuration, the ones that come with the project, and the card of one that is trained."""

import hashlib
import json
import shutil
from collections.abc import Mapping
from functools import partial
from math import prod
from pathlib import Path
from typing import Any

import pandas as pd

from repro.cnn.architecture import NetworkSettings
from repro.config.model import Configuration
from repro.config.sections import data_settings, of_network, plain, stated
from repro.errors import InputError
from repro.files import atomic_write, read_tensors, write_text

#: The one key of the weights' header, `configuration_digest`: safetensors writes several in any order.
CONFIGURATION = "configuration"


def training_config(config: Configuration) -> dict[str, Any]:
    """What decides the weights of a network, without the keys at the default of their class: a new key changes nothing.

    It has nothing of another recipe, divisor or kind of motion, nor what is only logged, kept or measured on the way.
    """
    s = stated(config, "signals", "network", "image", "training", "data")
    idle = ["source", "networks", "test_samples", "log_every", "checkpoint_every"]
    idle += [] if config.training.recipe == "paper" else ["paper"]
    parts = {"signals": s["signals"], "network": s["network"], "training": _without(s["training"], *idle)}
    parts["image"] = s["image"] if config.image.scale == "constant" else _without(s["image"], "constant")
    if config.data.motions != "tracked":
        return parts | {"data": _without(s["data"], "tracked")}
    experiment = {key: getattr(config.experiment, key) for key in ("margin_samples", "lead_in_s")}
    parts |= {"data": s["data"], **stated(config, "board"), "experiment": experiment}
    return parts | {"algorithm1": {"image_motion": config.algorithm1.image_motion}}


def _without(section: Mapping[str, Any], *keys: str) -> dict[str, Any]:
    return {key: value for key, value in section.items() if key not in keys}


def configuration_digest(config: Configuration) -> str:
    """SHA-256 of `training_config` as text: the same on every machine."""
    return hashlib.sha256(json.dumps(training_config(config), sort_keys=True).encode()).hexdigest()


def network_name(suffix: str) -> str:
    """Network of a suffix of file names, which is empty or ``-NETWORK``."""
    return suffix.removeprefix("-") or "published"


def stored_files(folder: str | Path, suffix: str) -> dict[str, Path]:
    """Files of a network by what they are."""
    names = {"weights": "cnn{}.safetensors", "history": "training{}.csv", "card": "model-card{}.md"}
    return {what: Path(folder) / name.format(suffix) for what, name in names.items()}


def check_stored(config: Configuration) -> None:
    """Refuse stored networks of another configuration; nothing is checked if networks are trained."""
    if config.training.source != "stored":
        return
    for suffix in ("", *(f"-{network}" for network in plain(config.networks))):
        whole = of_network(config, network_name(suffix))
        weights = stored_files(config.training.networks, suffix)["weights"]
        if whole.training.recipe != "paper" and weights.exists():
            _check_weights(weights, configuration_digest(whole))


def _check_weights(weights: Path, digest: str) -> None:
    """Refuse weights that were not trained with the configuration of this digest."""
    expected = "one trained with this configuration; training.source: trained trains it"
    _, metadata = read_tensors(weights, expected)
    if metadata.get(CONFIGURATION) != digest:
        raise InputError.at(str(weights), "a network of another configuration", expected)


def take_stored(suffix: str, out: dict[str, Path], folder: str, trained_as: str) -> None:
    """Copy a stored network, its history and its model card to `out`."""
    stored = stored_files(folder, suffix)
    weights = stored["weights"]
    _check_weights(weights, trained_as)
    digest = hashlib.sha256(weights.read_bytes()).hexdigest()
    try:
        card = stored["card"].read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError.at(str(stored["card"]), f"no readable text ({error})", f"the card of {weights}") from error
    if digest not in card:
        raise InputError.at(f"{weights}: SHA-256", digest, f"that of {stored['card'].name}")
    for what in ("weights", "history"):
        atomic_write(out[what], partial(shutil.copyfile, stored[what]))
    write_text(out["card"], f"{card}\nThis run did not train it: stored network, `{weights.as_posix()}`.\n")


def architecture(settings: NetworkSettings) -> pd.DataFrame:
    """Figure 7: every layer with its size and number of parameters."""
    k, maps, (p1, p2, p3) = settings.kernels, settings.maps, settings.pooled

    def count(name: str) -> int:
        return sum(prod(settings.weights[f"{name}.{part}"]) for part in ("weight", "bias"))

    rows = [
        ("input", "input", settings.image_size, settings.image_size, 2, "", 0),
        ("conv1", "convolution", 2 * p1, 2 * p1, maps, f"{k[0]}x{k[0]}x2x{maps}", count("conv1")),
        ("pool1", "max pool", p1, p1, maps, "2x2", 0),
        ("conv2", "convolution", 2 * p2, 2 * p2, maps, f"{k[1]}x{k[1]}x{maps}x{maps}", count("conv2")),
        ("pool2", "max pool", p2, p2, maps, "2x2", 0),
        ("conv3", "convolution", p3, p3, maps, f"{k[2]}x{k[2]}x{maps}x{maps}", count("conv3")),
        ("fc4", "fully connected", 1, 1, settings.hidden[0], "", count("fc4")),
        ("fc5", "fully connected", 1, 1, settings.hidden[1], "", count("fc5")),
        ("output", "output", 1, 1, 9, "", count("fc6")),
    ]
    return pd.DataFrame(rows, columns=["layer", "kind", "height", "width", "channels", "kernel", "parameters"])


def model_card(weights: Path, history: pd.DataFrame, precision: str, config: Configuration) -> str:
    """What a user of the weights wants to know, as Markdown."""
    data, training = data_settings(config), config.training
    layers, last = architecture(config.network), history.iloc[-1]
    reached, motions = "not reached in this budget", "Eq. 10 exactly"
    for row in history[history["test_loss"] <= 1e-3][:1].itertuples():
        reached = f"step {row.step}, after {row.seconds:.0f} s"
    if config.data.motions == "tracked":
        t, shown = config.data.tracked, config.algorithm1.image_motion
        motions = f"Eq. 10 as {t.arms} simulated arms track it (seed {t.seed}); "
        motions += f"f of the image on the {shown} motion"
    size = "\n".join(
        f"| {r.layer} | {r.kind} | {r.height} x {r.width} x {r.channels} | {r.kernel} | {r.parameters} |"
        for r in layers.itertuples()
    )
    divisor = data.image.scale + (f" ({data.image.constant:g})" if data.image.scale == "constant" else "")
    return f"""# Model card: {weights.name}

Reads the nine parametric residuals of a two-joint arm off the 100 x 100 x 2 signal image of Eq. 9.
Trained on torques computed by numeric substitution in Eq. 1; no measured data.

| layer | kind | output | kernel | parameters |
|---|---|---|---|---|
{size}

- Parameters: {int(layers["parameters"].sum())}
- Recipe: {training.recipe}, {training.steps} steps of {training.batch} images, seed {training.seed}, \
{precision} arithmetic in layers 1 to 4
- Arms: {data.prior} prior; guesses: {data.exact_share:.0%} exact, {data.near_share:.0%} near, \
the rest uniform on {data.guess_low:g} to {data.guess_high:g}
- Motions: {motions}
- Torque beyond Eq. 1, at most: {data.unmodelled}
- Image: Z1 divided by {divisor}
- Final loss: training {last["train_loss"]:.3e}, held-out {last["test_loss"]:.3e}
- Held-out loss of 1e-3: {reached}
- Training time: {last["seconds"]:.0f} s of wall time
- SHA-256 of the weights: `{hashlib.sha256(weights.read_bytes()).hexdigest()}`

Use: identification of arms that are sent Eq. 10's trajectory. Not for other motions: the image's meaning
depends on the motion. Parameters are read in units of the largest torque.
"""
