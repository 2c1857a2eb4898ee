"""From sections of a checked configuration to the settings of each room.

Each function reads only the sections it names, so that a workflow rule depends on just what it uses.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from repro.cnn.architecture import NetworkSettings, PaperSchedule, TrainingSettings
from repro.cnn.dataset import DataSettings, UnmodelledSettings
from repro.cnn.image import ImageSettings
from repro.cnn.priors import GuessSettings
from repro.config import merged
from repro.identification.algorithm1.refinement import RefinementSettings
from repro.identification.algorithm1.search import SearchSettings
from repro.model.parameters import Array
from repro.signals.dct import SignalSettings
from repro.signals.metric import MetricSettings

Config = Mapping[str, Any]


def signal_settings(config: Config) -> SignalSettings:
    """Sampling and filters, from section ``signals``."""
    s = config["signals"]
    return SignalSettings(
        h=s["sampling_period_s"],
        c_f=s["filter_coefficient"],
        omega_unit=s["frequency_reading"],
        samples=s["image_samples"],
        duration=s["duration_s"],
        normalise_motion=s["normalise_motion"],
    )


def metric_settings(config: Config) -> MetricSettings:
    """Formulas of **metr2ev**, from section ``metric``."""
    return MetricSettings(**config["metric"])


def network_settings(config: Config) -> NetworkSettings:
    """Sizes of the CNN, from sections ``signals`` and ``network``."""
    n = config["network"]
    return NetworkSettings(
        image_size=config["signals"]["image_samples"], hidden=tuple(n["hidden"]), sigmoid_gain=n["sigmoid_gain"]
    )


def of_network(config: Config, network: str) -> dict[str, Any]:
    """Configuration as a network changes it, from section ``networks``; the published one changes nothing."""
    return merged(config, config["networks"][network]) if network != "published" else dict(config)


def data_settings(config: Config) -> DataSettings:
    """Training distribution, from sections ``data`` and ``image``."""
    d = config["data"]
    names = ("guess_low", "guess_high", "exact_share", "near_share", "near_low", "near_high")
    guess = GuessSettings(*(d[name] for name in names))
    image, unmodelled = ImageSettings(**config["image"]), UnmodelledSettings(**d["unmodelled"])
    return DataSettings(d["prior"], guess, image, d["label"], unmodelled)


def training_settings(config: Config) -> TrainingSettings:
    """Schedule and budget, from section ``training``; the paper's constants only where the schedule is the paper's."""
    t = {key: value for key, value in config["training"].items() if key not in ("paper", "source", "networks")}
    paper = PaperSchedule(**config["training"]["paper"]) if t["recipe"] == "paper" else PaperSchedule()
    return TrainingSettings(**t, paper=paper)


def search_settings(config: Config) -> SearchSettings:
    """Constants of Algorithm 1, from sections ``algorithm1`` and ``metric``."""
    a = dict(config["algorithm1"])
    threshold, low, high = a.pop("threshold_numeric"), a.pop("guess_low"), a.pop("guess_high")
    return SearchSettings(**a, threshold=threshold, low=low, high=high, metric=metric_settings(config))


def refinement_settings(config: Config) -> RefinementSettings:
    """Budget of the refinement, from section ``refinement``."""
    return RefinementSettings(**config["refinement"])


def numeric_arms(config: Config) -> dict[str, Array]:
    """Nine parameters of each test arm of Section V-B, from section ``numeric``."""
    return {name: np.array(beta, dtype=np.float64) for name, beta in config["numeric"]["arms"].items()}
