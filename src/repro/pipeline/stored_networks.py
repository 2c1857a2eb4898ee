"""Networks that come with the project: taken instead of trained, if they belong to the configuration."""

import hashlib
import json
import shutil
from functools import partial
from pathlib import Path
from typing import Any

from repro.errors import InputError
from repro.files import atomic_write, read_tensors, write_text
from repro.pipeline.job import Config
from repro.settings import of_network

#: The one key of the weights' header, `configuration_digest`: safetensors writes several in any order.
CONFIGURATION = "configuration"
#: Where a network comes from is a choice of the run, not of what is trained.
SOURCE_KEYS = ("source", "networks")


def training_config(config: Config) -> dict[str, Any]:
    """What decides a network: nothing of another recipe or another divisor."""
    left_out = SOURCE_KEYS if config["training"]["recipe"] == "paper" else (*SOURCE_KEYS, "paper")
    image = config["image"] if config["image"]["scale"] == "constant" else {"scale": config["image"]["scale"]}
    data = {key: value for key, value in config["data"].items() if key != "tracked"}
    how: dict[str, Any] = {"data": data}
    if data["motions"] == "tracked":
        e = config["experiment"]
        how = {
            "data": config["data"],
            "board": config["board"],
            "experiment": {key: e[key] for key in ("margin_samples", "lead_in_s")},
            "algorithm1": {"image_motion": config["algorithm1"]["image_motion"]},
        }
    return {
        **{name: config[name] for name in ("signals", "network")},
        **how,
        "image": image,
        "training": {key: value for key, value in config["training"].items() if key not in left_out},
    }


def configuration_digest(config: Config) -> str:
    """SHA-256 of `training_config` as text: the same on every machine."""
    text = json.dumps(training_config(config), sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()


def stored_files(folder: str | Path, suffix: str) -> dict[str, Path]:
    """Files of a network by what they are; a suffix is empty or ``-VARIANT``."""
    names = {"weights": "cnn{}.safetensors", "history": "training{}.csv", "card": "model-card{}.md"}
    return {what: Path(folder) / name.format(suffix) for what, name in names.items()}


def check_stored(config: Config) -> None:
    """Refuse stored networks of another configuration; nothing is checked if networks are trained."""
    if config["training"]["source"] != "stored":
        return
    for network in ("published", *config["networks"]):
        whole = of_network(config, network)
        weights = stored_files(config["training"]["networks"], "" if network == "published" else f"-{network}")[
            "weights"
        ]
        if whole["training"]["recipe"] != "paper" and weights.exists():
            _check_weights(weights, whole)


def _check_weights(weights: Path, config: Config) -> None:
    """Refuse weights that were not trained with this configuration."""
    expected = "one trained with this configuration; training.source: trained trains it"
    _, metadata = read_tensors(weights, expected)
    if metadata.get(CONFIGURATION) != configuration_digest(config):
        raise InputError.at(str(weights), "a network of another configuration", expected)


def take_stored(network: str, out: dict[str, Path], config: Config) -> None:
    """Copy a stored network, its history and its model card to `out`."""
    suffix = "" if network == "published" else f"-{network}"
    stored = stored_files(config["training"]["networks"], suffix)
    weights = stored["weights"]
    _check_weights(weights, config)
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
