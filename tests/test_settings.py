"""Every key of the configuration arrives where it is meant, and each room reads its own sections only."""

from pathlib import Path

import numpy as np
import pytest
import yaml

from repro import settings
from repro.cnn.architecture import PaperSchedule, TrainingSettings
from repro.cnn.dataset import DataSettings, UnmodelledSettings
from repro.cnn.image import ImageSettings
from repro.cnn.priors import GuessSettings
from repro.identification.algorithm1.refinement import RefinementSettings
from repro.identification.algorithm1.search import ARM_THRESHOLD, SearchSettings
from repro.pipeline.experiment import program_settings
from repro.signals.dct import SignalSettings
from repro.signals.metric import MetricSettings
from repro.signals.programs import TrajectorySettings

pytestmark = pytest.mark.slow

ROOT = Path(__file__).resolve().parent.parent

#: A value of its own for every key that is passed on by its place, and of the networks' changes.
CONFIG = yaml.safe_load("""
signals: {sampling_period_s: 0.005, filter_coefficient: 2.0e-4, frequency_reading: index, image_samples: 64,
          duration_s: 7.5, normalise_motion: true}
data: {motions: ideal, unmodelled: {stribeck: 0.41, ripple: 0.09, noise: 0.02, delay_s: 0.001},
       prior: links, label: physical, guess_low: 0.011, guess_high: 2.5, exact_share: 0.15, near_share: 0.35,
       near_low: 0.004, near_high: 0.6}
image: {scale: channel-max, constant: 5.5}
training:
  {recipe: streamed, steps: 101, batch: 7, learning_rate: 0.003, warmup: 11, seed: 9, test_samples: 13, log_every: 19,
   checkpoint_every: 23, precision: float32,
   paper: {images: 500, train_share: 0.7, learning_rate: 0.05, learning_rate_slope: 1.0e-6, gradient_gain: 50.0}}
networks:
  tracked: {image: {scale: constant}}
  paper-recipe: {training: {recipe: paper, steps: 202, batch: 3}}
""")
NETWORKS = {"published": "channel-max", "tracked": "constant", "paper-recipe": "channel-max"}


def test_sampling_and_filters():
    expected = SignalSettings(h=0.005, c_f=2e-4, omega_unit="index", samples=64, duration=7.5, normalise_motion=True)
    assert settings.signal_settings(CONFIG) == expected


@pytest.mark.parametrize(("network", "scale"), NETWORKS.items())
def test_data_of_a_network(network, scale):
    guess = GuessSettings(low=0.011, high=2.5, exact_share=0.15, near_share=0.35, near_low=0.004, near_high=0.6)
    found = settings.data_settings(settings.of_network(CONFIG, network))
    beyond = UnmodelledSettings(stribeck=0.41, ripple=0.09, noise=0.02, delay_s=0.001)
    assert found == DataSettings("links", guess, ImageSettings(scale, 5.5), "physical", beyond)


@pytest.mark.parametrize("network", NETWORKS)
def test_training_of_a_network(network):
    schedule = PaperSchedule(
        images=500, train_share=0.7, learning_rate=0.05, learning_rate_slope=1e-6, gradient_gain=50.0
    )
    own = {"recipe": "paper", "steps": 202, "batch": 3} if network == "paper-recipe" else {"steps": 101, "batch": 7}
    expected = TrainingSettings(
        learning_rate=0.003,
        warmup=11,
        seed=9,
        test_samples=13,
        log_every=19,
        checkpoint_every=23,
        precision="float32",
        # The streamed networks do not read the paper's schedule, so that changing it does not train them again.
        paper=schedule if network == "paper-recipe" else PaperSchedule(),
        **own,
    )
    assert settings.training_settings(settings.of_network(CONFIG, network)) == expected


def test_test_arms_are_of_floats():
    config = yaml.safe_load((ROOT / "config" / "config.yaml").read_text(encoding="utf-8"))
    config["numeric"]["arms"]["N2"] = [1, 2, 3, 4, 5, 6, 7, 8, 9]
    arms = settings.numeric_arms(config)
    assert list(arms) == ["N1", "N2", "N3", "N4"] and arms["N2"].dtype == np.float64


def test_defaults_agree_with_the_default_configuration():
    config = yaml.safe_load((ROOT / "config" / "config.yaml").read_text(encoding="utf-8"))
    assert settings.refinement_settings(config) == RefinementSettings()
    assert settings.search_settings(config) == SearchSettings()
    assert settings.metric_settings(config) == MetricSettings()
    assert program_settings(config) == TrajectorySettings(duration=config["signals"]["duration_s"])


def test_the_default_configuration_is_the_published_one_where_the_paper_gives_a_value():
    config = yaml.safe_load((ROOT / "config" / "config.yaml").read_text(encoding="utf-8"))
    signals, search = settings.signal_settings(config), settings.search_settings(config)
    assert (signals.h, signals.c_f, signals.samples) == (2.5e-3, 1e-4, 100)
    assert round(signals.duration / signals.h) == 3770  # 3 pi s
    assert (search.executions, search.threshold, search.low, search.high) == (100, 0.9282, 1e-3, 3.0)
    assert ARM_THRESHOLD == 0.9237
    assert settings.metric_settings(config).exponent == 0.4
    paper = settings.training_settings(settings.of_network(config, "paper-recipe"))
    assert (paper.recipe, paper.steps, paper.batch) == ("paper", 500_000, 1)
    assert paper.paper == PaperSchedule(10_000, 0.8, 20e-3, 0.2e-7, 100.0)
    guess = settings.data_settings(config).guess
    assert (guess.low, guess.high) == (1e-3, 3.0)
