"""Every key of the configuration arrives where it is meant, and each room reads its own sections only."""

import numpy as np
import pytest
import yaml
from experiment_example import changed, full_config

from repro import settings
from repro.cnn.architecture import PaperSchedule, TrainingSettings
from repro.cnn.dataset import DataSettings, UnmodelledSettings
from repro.cnn.image import ImageSettings
from repro.cnn.priors import GuessSettings
from repro.identification.algorithm1.refinement import RefinementSettings
from repro.identification.algorithm1.search import ARM_THRESHOLD, SearchSettings
from repro.model.dynamics import ArmGeometry
from repro.pipeline.experiment import program_settings
from repro.signals.dct import SignalSettings
from repro.signals.metric import MetricSettings
from repro.signals.programs import TrajectorySettings
from repro.signals.validation_motions import Circle, Profile, RandomMotion, Sinusoid

pytestmark = pytest.mark.slow

DEFAULT = full_config()
#: A value of its own for every key that is passed on by its place, and of the networks' changes.
CONFIG = yaml.safe_load("""
signals: {sampling_period_s: 0.005, filter_coefficient: 2.0e-4, frequency_reading: hertz, image_samples: 64,
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
    expected = SignalSettings(h=0.005, c_f=2e-4, omega_unit="hertz", samples=64, duration=7.5, normalise_motion=True)
    assert settings.signal_settings(CONFIG) == expected


@pytest.mark.parametrize(("network", "scale"), NETWORKS.items())
def test_data_and_training_of_a_network(network, scale):
    config = settings.of_network(CONFIG, network)
    guess = GuessSettings(low=0.011, high=2.5, exact_share=0.15, near_share=0.35, near_low=0.004, near_high=0.6)
    beyond = UnmodelledSettings(stribeck=0.41, ripple=0.09, noise=0.02, delay_s=0.001)
    data = DataSettings("links", guess, ImageSettings(scale, 5.5), "physical", beyond)
    assert settings.data_settings(config) == data
    own = {"recipe": "paper", "steps": 202, "batch": 3} if network == "paper-recipe" else {"steps": 101, "batch": 7}
    # The streamed networks do not read the paper's schedule, so that changing it does not train them again.
    own["paper"] = PaperSchedule(500, 0.7, 0.05, 1e-6, 50.0) if network == "paper-recipe" else PaperSchedule()
    common = {"learning_rate": 0.003, "warmup": 11, "seed": 9, "test_samples": 13, "log_every": 19}
    expected = TrainingSettings(checkpoint_every=23, precision="float32", **common, **own)
    assert settings.training_settings(config) == expected


def test_test_arms_are_of_floats():
    arms = settings.numeric_arms({"numeric": {"arms": {"N2": [1, 2, 3], "N1": [0.5]}}})
    assert list(arms) == ["N2", "N1"] and arms["N2"].dtype == np.float64


def test_defaults_agree_with_the_default_configuration():
    assert settings.refinement_settings(DEFAULT) == RefinementSettings()
    assert settings.search_settings(DEFAULT) == SearchSettings()
    assert settings.metric_settings(DEFAULT) == MetricSettings()
    changed = DEFAULT | {"metric": {**DEFAULT["metric"], "exponent": 1.7}}
    assert settings.search_settings(changed) == SearchSettings(metric=settings.metric_settings(changed))
    assert settings.metric_settings(changed) != MetricSettings()


def test_each_motion_has_its_settings():
    motions = {
        "duration_s": 11.0,
        "t1": {"samples": 900, "bands": 14.0, "range_rad": 0.7, "range_of": "motion"},
        "t2": {"samples": 800, "turns": 3.5, "centre": 0.6},
        "t3": {"samples": 700, "levels": 0.4},
        "t4": {"samples": 600, "amplitude_rad": [0.2, 0.3], "frequency_hz": [0.5, 0.9]},
    }
    config = changed(DEFAULT, experiment=motions, arm={"link_lengths_m": [0.2, 0.11]})
    assert program_settings(config) == TrajectorySettings(
        geometry=ArmGeometry(0.2, 0.11),
        duration=11.0,
        t1=RandomMotion(900, 14.0, 0.7, "motion"),
        t2=Circle(800, 3.5, 0.6),
        t3=Profile(700, 0.4),
        t4=Sinusoid(600, (0.2, 0.3), (0.5, 0.9)),
    )


def test_the_default_configuration_is_the_published_one_where_the_paper_gives_a_value():
    signals, search = settings.signal_settings(DEFAULT), settings.search_settings(DEFAULT)
    assert (signals.h, signals.c_f, signals.samples) == (2.5e-3, 1e-4, 100)
    assert round(signals.duration / signals.h) == 3770  # 3 pi s
    assert (search.executions, search.threshold, search.low, search.high) == (100, 0.9282, 1e-3, 3.0)
    assert ARM_THRESHOLD == 0.9237
    assert settings.metric_settings(DEFAULT).exponent == 0.4
    paper = settings.training_settings(settings.of_network(DEFAULT, "paper-recipe"))
    assert (paper.recipe, paper.steps, paper.batch) == ("paper", 500_000, 1)
    assert paper.paper == PaperSchedule(10_000, 0.8, 20e-3, 0.2e-7, 100.0)
    guess = settings.data_settings(DEFAULT).guess
    assert (guess.low, guess.high) == (1e-3, 3.0)
