"""The networks of the workflow, as the configuration asks for them."""

from pathlib import Path

import pytest
import torch
from experiment_example import full_config

from repro.pipeline.networks import algorithm1_of
from repro.pipeline.stored_networks import configuration_digest
from repro.settings import of_network

WEIGHTS = Path(__file__).resolve().parents[2] / "data/networks/cnn.safetensors"


@pytest.mark.parametrize("precision", ["float32", "bfloat16"])
def test_images_are_read_in_the_arithmetic_asked_for(precision):
    config = of_network(full_config(), "published")
    said = configuration_digest(config)
    asked = {**config, "training": {**config["training"], "precision": precision}}
    assert algorithm1_of("published", str(WEIGHTS), asked, said).network.dtype == getattr(torch, precision)
