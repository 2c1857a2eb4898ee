"""Algorithm 1 with a trained network, as the configuration asks for it."""

from dataclasses import replace
from pathlib import Path

from repro.cnn.network import load_network
from repro.identification.algorithm1.refinement import Algorithm1
from repro.pipeline.job import Config
from repro.settings import data_settings, network_settings, refinement_settings, search_settings, training_settings


def algorithm1_of(variant: str, weights: str, config: Config, said: str) -> Algorithm1:
    """A trained network, whose weights must say `said` of themselves, with the settings of its configuration."""
    network = load_network(Path(weights), network_settings(config), said, training_settings(config).precision)
    image, search = data_settings(config).image, search_settings(config)
    return Algorithm1(variant, network, image, search, refinement_settings(config))


def for_the_arm(algorithm1: Algorithm1, config: Config) -> Algorithm1:
    """The same with the threshold of the experiment."""
    return replace(algorithm1, search=replace(algorithm1.search, threshold=config["experiment"]["threshold"]))
