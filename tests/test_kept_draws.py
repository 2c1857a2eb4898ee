"""What random generators draw from their seeds, as it was kept: every result is of these numbers."""

from typing import get_args

import numpy as np
from experiment_example import full_config
from kept import flat, same

from repro.cnn.dataset import DataSettings, UnmodelledSettings, draw_samples, sample_motion
from repro.cnn.priors import GuessSettings, Prior, sample_beta, training_guess
from repro.experiments.simulated_arms import draw_arms, draw_built_arms
from repro.identification.algorithm1.refinement import RefinementSettings, _move, uniform_guesses
from repro.identification.algorithm1.search import SearchSettings
from repro.identification.armfile import Arm
from repro.identification.exciting_motion import Envelope, expected_accuracy, published
from repro.identification.uncertainty import resample
from repro.paper.metric_search import MOTIONS
from repro.signals.dct import SignalSettings
from repro.signals.programs import PROGRAMS, TrajectorySettings, peaks, reference_trajectory
from repro.signals.trajectories import identification_trajectory
from repro.streams import Stream, stream


def rng():
    return np.random.default_rng(7)


def draws():
    config, arms = full_config(), sample_beta(rng(), 6)
    yield "streams", [stream(3, name, 2).random() for name in Stream]
    yield "priors", {prior: sample_beta(rng(), 4, prior) for prior in get_args(Prior)}
    yield "guesses", training_guess(rng(), np.repeat(arms[:1], 12, axis=0), GuessSettings())
    yield "held arms", draw_arms(rng(), 3, config)
    yield "built arms", draw_built_arms(rng(), 3, config)
    yield "uniform guesses", uniform_guesses(SearchSettings(executions=2, inner_limit=3), rng())
    yield "moves", _move(arms, RefinementSettings(), 0.02, rng())
    yield "resampled", resample(40, 7, rng())
    for name in PROGRAMS:
        motion = reference_trajectory(name, TrajectorySettings(), rng())
        yield name, [motion.n1, motion.n2, motion.h, motion.q[:, 5::500], *peaks(motion, arms[0])]
    limits = ((-1.5, 1.2), (-1.4, 2.0))
    envelope = Envelope(Arm(position_limit=limits, speed_limit=(5.0, 6.0), torque_limit=(1.7, 0.8)), arms[0] / 2.0)
    motion = published(envelope, (1000, 0.01), 0.5, np.array([0.05, 0.03]))
    yield "Eq. 10 within limits", [motion.time[-1], motion.q[:, 5::200], motion.dq[:, 5::200], motion.ddq[:, 5::200]]
    yield "expected accuracy", expected_accuracy((motion.q, motion.dq, motion.ddq), np.array([0.05, 0.03]), 20.0)
    yield "motions of the search", {str(motion): motion.draw(rng()).q[:, 5::2000] for motion in MOTIONS}
    signals = SignalSettings()
    motion = sample_motion(
        identification_trajectory(signals.duration_s, signals.sampling_period_s), signals, unmodelled=True
    )
    for settings in (DataSettings(), DataSettings(unmodelled=UnmodelledSettings(0.3, 0.1, 0.02, 0.004))):
        samples = draw_samples(rng(), 3, motion, settings)
        yield "samples", [samples.residual, samples.u[..., ::25], samples.v[..., ::25]]


def plain(value):
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    return value.tolist() if hasattr(value, "tolist") else value


def test_draws_are_those_kept(file_regression):
    lines = [line for name, value in draws() for line in flat(plain(value), f".{name}")]
    file_regression.check("\n".join(lines) + "\n", check_fn=same, basename="draws")
