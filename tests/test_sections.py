"""Sections of the configuration are the settings of what they configure; a job has those that its rule names."""

from dataclasses import asdict, fields, make_dataclass

import pytest
from experiment_example import changed, full_config

from repro.cnn.architecture import NetworkSettings, PaperSchedule, TrainingSettings
from repro.cnn.dataset import DataSettings, UnmodelledSettings
from repro.config.sections import data_settings, job_configuration, of_network, search_settings, stated
from repro.experiments.arm import program_settings
from repro.experiments.stored_networks import configuration_digest, training_config
from repro.identification.algorithm1.refinement import RefinementSettings
from repro.identification.algorithm1.search import ARM_THRESHOLD, SearchSettings
from repro.keys import renamed
from repro.model.dynamics import ArmGeometry
from repro.signals.dct import SignalSettings
from repro.signals.metric import MetricSettings
from repro.signals.programs import TrajectorySettings
from repro.signals.validation_motions import Circle, Profile, RandomMotion, Sinusoid

pytestmark = pytest.mark.slow

DEFAULT = full_config()


def test_settings_of_two_sections():
    config = changed(
        DEFAULT,
        data={"label": "physical", "guess_low": 0.011, "unmodelled": {"noise": 0.02}},
        image={"scale": "constant", "constant": 5.5},
        algorithm1={"executions": 7, "guess_high": 2.5},
        metric={"exponent": 1.7},
    )
    data = data_settings(config)
    assert (data.label, data.guess_low, data.prior) == ("physical", 0.011, "mixture")
    assert (data.image.constant, data.unmodelled) == (5.5, UnmodelledSettings(noise=0.02))
    assert search_settings(config) == SearchSettings(executions=7, guess_high=2.5, metric=MetricSettings(exponent=1.7))


def test_defaults_agree_with_the_default_configuration():
    assert DEFAULT.refinement == RefinementSettings()
    assert search_settings(DEFAULT) == SearchSettings()
    assert data_settings(DEFAULT) == DataSettings()
    assert (DEFAULT.metric, DEFAULT.signals, DEFAULT.network) == (MetricSettings(), SignalSettings(), NetworkSettings())


def test_each_motion_has_its_settings():
    motions = {
        "duration_s": 11.0,
        "t1": {"samples": 900, "bands": 14.0, "range_rad": 0.7, "range_of": "motion"},
        "t2": {"samples": 800, "turns": 3.5, "centre": 0.6},
        "t3": {"samples": 700, "levels": 0.4},
        "t4": {"samples": 600, "amplitude_rad": (0.2, 0.3), "frequency_hz": (0.5, 0.9)},
    }
    config = changed(DEFAULT, experiment=motions, arm={"link_lengths_m": (0.2, 0.11)})
    assert program_settings(config) == TrajectorySettings(
        geometry=ArmGeometry(0.2, 0.11),
        duration=11.0,
        t1=RandomMotion(900, 14.0, 0.7, "motion"),
        t2=Circle(800, 3.5, 0.6),
        t3=Profile(700, 0.4),
        t4=Sinusoid(600, (0.2, 0.3), (0.5, 0.9)),
    )


def test_the_default_configuration_is_the_published_one_where_the_paper_gives_a_value():
    signals, search = DEFAULT.signals, search_settings(DEFAULT)
    assert (signals.sampling_period_s, signals.filter_coefficient, signals.image_samples) == (2.5e-3, 1e-4, 100)
    assert round(signals.duration_s / signals.sampling_period_s) == 3770  # 3 pi s
    assert (search.executions, search.threshold, search.guess_low, search.guess_high) == (100, 0.9282, 1e-3, 3.0)
    assert ARM_THRESHOLD == 0.9237
    assert DEFAULT.metric.exponent == 0.4
    paper = of_network(DEFAULT, "paper-recipe").training
    assert (paper.recipe, paper.steps, paper.batch) == ("paper", 500_000, 1)
    assert paper.paper == PaperSchedule(10_000, 0.8, 20e-3, 0.2e-7, 100.0)
    assert (DEFAULT.data.guess_low, DEFAULT.data.guess_high) == (1e-3, 3.0)


# --- A job's configuration ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("network", ["published", "tracked-measured", "paper-recipe"])
def test_a_job_has_what_its_rule_states(network):
    config = changed(of_network(DEFAULT, network), data={"tracked": {"arms": 41}}, signals={"duration_s": 7})
    names = ("signals", "data", "training", "experiment", "networks")
    job = job_configuration(stated(config, *names), 71)
    assert (job.signals, job.data, job.experiment) == (config.signals, config.data, config.experiment)
    assert job.training.checkpoint_every == 71
    assert changed(job, training={"checkpoint_every": 500}).training == changed(config.training, checkpoint_every=500)
    assert of_network(job_configuration(stated(DEFAULT, *names, "algorithm1", "image", "refinement"), 1), network)
    with pytest.raises(AttributeError):
        job.board  # noqa: B018


def test_a_job_cannot_read_a_key_that_its_rule_leaves_out():
    parts = stated(DEFAULT, "numeric")
    del parts["numeric"]["seeds"]
    job = job_configuration(parts, 1)
    assert job.numeric.validation_samples == DEFAULT.numeric.validation_samples
    with pytest.raises(AttributeError):
        job.numeric.seeds  # noqa: B018


# --- What decides a network ---------------------------------------------------------------------------------------


def test_a_new_key_at_its_default_keeps_the_digest_of_every_network():
    config = DEFAULT
    for name in ("signals", "network", "image", "training", "data"):
        section = getattr(config, name)
        wider = make_dataclass("Wider", [("momentum", float, 0.95)], bases=(type(section),), frozen=True)
        own = wider(**{field.name: getattr(section, field.name) for field in fields(section)})
        new = config.model_copy(update={name: own})
        assert configuration_digest(new) == configuration_digest(config), name
        assert configuration_digest(changed(new, **{name: {"momentum": 0.5}})) != configuration_digest(config), name


def test_keys_that_change_no_weight_keep_the_digest():
    logged = {"checkpoint_every": 7, "log_every": 8, "test_samples": 9, "source": "stored", "networks": "elsewhere"}
    assert configuration_digest(changed(DEFAULT, training=logged)) == configuration_digest(DEFAULT)
    assert configuration_digest(changed(DEFAULT, training={"warmup": 9})) != configuration_digest(DEFAULT)


def test_no_default_changes_below_the_stored_networks():
    # Their digest names what is not at the default of its class: with another one they have to be trained again.
    assert training_config(DEFAULT) == {"signals": {}, "network": {}, "training": {}, "image": {}, "data": {}}
    decisive = {key: x for key, x in asdict(TrainingSettings()).items() if key not in ("log_every", "test_samples")}
    assert decisive == {
        "recipe": "streamed",
        "steps": 4000,
        "batch": 64,
        "learning_rate": 5e-3,
        "warmup": 400,
        "seed": 1,
        "checkpoint_every": 500,
        "precision": "auto",
        "paper": asdict(PaperSchedule(10_000, 0.8, 20e-3, 0.2e-7, 100.0)),
    }
    assert asdict(DataSettings()) == {
        "guess_low": 1e-3,
        "guess_high": 3.0,
        "exact_share": 0.1,
        "near_share": 0.2,
        "near_low": 3e-3,
        "near_high": 0.5,
        "label": "largest-torque",
        "unmodelled": {"stribeck": 0.0, "ripple": 0.0, "noise": 0.0, "delay_s": 0.0},
        "prior": "mixture",
        "image": {"scale": "shared-max", "constant": 4.0},
    }
    assert asdict(SignalSettings()) == {
        "sampling_period_s": 2.5e-3,
        "filter_coefficient": 1e-4,
        "frequency_reading": "index",
        "image_samples": 100,
        "duration_s": 9.42477796076938,
        "normalise_motion": False,
    }
    assert asdict(NetworkSettings()) == {"hidden": (100, 50), "sigmoid_gain": 1.0}
    assert asdict(DEFAULT.data.tracked) == {
        "arms": 320,
        "seed": 1,
        "load_share": 0.8,
        "least_inertia_kg_m2": (0.01, 0.004),
        "largest_error_rad": 0.2,
        "stribeck": 1.2,
        "ripple_nm": 0.2,
        "ripple_cycles": 11.0,
    }


# --- Earlier names ------------------------------------------------------------------------------------------------


def test_an_earlier_name_is_taken_with_a_warning():
    with pytest.warns(DeprecationWarning, match="filter_coefficient"):
        assert SignalSettings(c_f=2e-4) == SignalSettings(filter_coefficient=2e-4)
    with pytest.warns(DeprecationWarning, match="guess_high"):
        assert SearchSettings(5, high=2.0) == SearchSettings(5, guess_high=2.0)
    with pytest.raises(TypeError):
        renamed(old="new")(SearchSettings)(older=1)
