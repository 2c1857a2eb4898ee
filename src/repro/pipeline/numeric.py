"""The numeric experiment: N1 to N4 identified, rebuilt and validated (Section V-B)."""

import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import pandas as pd

from repro.cnn.dataset import DataSettings, SignalSettings
from repro.cnn.factored import FactoredCNN
from repro.cnn.priors import sample_beta
from repro.identify.algorithm1 import SearchSettings
from repro.identify.prepare import prepare
from repro.identify.refinement import RefinementSettings
from repro.model.dynamics import inverse_dynamics, rebuild_torque, regressor
from repro.model.parameters import Array
from repro.pipeline.methods import Identifier
from repro.progress import Progress
from repro.settings import NumericSettings
from repro.signals.metric import MetricSettings, metr2ev
from repro.signals.trajectories import Motion, identification_trajectory, random_trajectory
from repro.streams import Stream, stream

_LOG = logging.getLogger(__name__)

#: Arms averaged for the mean training torque of fit2trt.
MEAN_ARMS = 10_000


def mean_training_torque(signals: SignalSettings, data: DataSettings, seed: int) -> Array:
    """Mean torque of the training data along the identification trajectory (centre of Fig. 9).

    Parameters
    ----------
    signals : SignalSettings
        Sampling.
    data : DataSettings
        Distribution of the training arms.
    seed : int
        Training seed.

    Returns
    -------
    array of shape (2, N)
        Torque, N m. Eq. 1 is linear in beta, so it is the torque of the mean arm.
    """
    motion = identification_trajectory(signals.duration, signals.h)
    beta = sample_beta(stream(seed, Stream.TRAINING_ARMS), MEAN_ARMS, data.prior).mean(0)
    return inverse_dynamics(motion.q, motion.dq, motion.ddq, beta)


@dataclass(frozen=True)
class Experiment:
    """Settings of one run of the numeric experiment.

    Attributes
    ----------
    variant : str
        Network variant.
    signals, data, search, refinement, numeric
        Settings of the rooms.
    tau_mean : array of shape (2, N)
        Mean torque of the training data, N m.
    """

    variant: str
    signals: SignalSettings
    data: DataSettings
    search: SearchSettings
    refinement: RefinementSettings
    numeric: NumericSettings
    tau_mean: Array


def identify_arms(network: FactoredCNN, experiment: Experiment, seed: int) -> dict[str, Any]:
    """Identify every test arm by Algorithm 1, by its refinement, and by the refinement's control without the network.

    Parameters
    ----------
    network : FactoredCNN
        Trained network.
    experiment : Experiment
        Settings.
    seed : int
        Seeds the guesses.

    Returns
    -------
    dict
        For each arm its true parameters and for each method the estimate, its similarity and its cost in
        images, ready for JSON.
    """
    e = experiment
    margin, signals = e.numeric.margin, e.signals
    recorded = identification_trajectory(signals.duration, signals.h, margin)
    y_recorded = regressor(recorded.q, recorded.dq, recorded.ddq)
    identifier = Identifier(e.variant, network, e.data.image, e.search, e.refinement)
    progress = Progress(f"{e.variant} image, seed {seed}")
    arms: dict[str, Any] = {}
    for index, (name, beta) in enumerate(e.numeric.arms.items()):
        tau = rebuild_torque(y_recorded, beta)
        prepared = prepare(recorded.q, tau, e.tau_mean, signals, margin, margin + e.tau_mean.shape[-1])
        methods, met = identifier.methods(
            prepared,
            stream(seed, Stream.SEARCH, index),
            partial(stream, seed, Stream.REFINE, index),
        )
        arms[name] = {"true": beta.tolist(), "executions_over_threshold": met, "methods": methods}
        _LOG.info("%s: %d of %d executions over the threshold", name, met, e.search.executions)
        progress(index + 1, len(e.numeric.arms))
    return {"variant": e.variant, "seed": seed, "arms": arms}


def validation_motion(signals: SignalSettings, numeric: NumericSettings, seed: int) -> Motion:
    """Random trajectory that the estimates of a seed are validated on (Fig. 16)."""
    rng = stream(seed, Stream.VALIDATION)
    return random_trajectory(rng, signals.duration, signals.h, signals.c_f, numeric.validation_reading)


def motion_of(trajectory: str, signals: SignalSettings, numeric: NumericSettings, seed: int) -> Motion:
    """Motion that estimates are scored on: ``ID`` (Eq. 10) or ``validation``."""
    if trajectory == "ID":
        return identification_trajectory(signals.duration, signals.h)
    return validation_motion(signals, numeric, seed)


def score_estimates(
    identifications: Sequence[Mapping[str, Any]],
    signals: SignalSettings,
    numeric: NumericSettings,
    metric: MetricSettings,
) -> pd.DataFrame:
    """Similarity of the numeric torques and their rebuilding, for every seed.

    Parameters
    ----------
    identifications : sequence of dict
        Results of `identify_arms`.
    signals, numeric, metric
        Settings.

    Returns
    -------
    DataFrame
        Columns ``case, method, seed, trajectory, joint, time, frequency, total``; fractions of 1.
    """
    rows = []
    for run in identifications:
        for trajectory in ("ID", "validation"):
            motion = motion_of(trajectory, signals, numeric, run["seed"])
            y = regressor(motion.q, motion.dq, motion.ddq)
            for case, arm in run["arms"].items():
                tau = rebuild_torque(y, np.array(arm["true"]))
                for method, estimate in arm["methods"].items():
                    s = metr2ev(tau, rebuild_torque(y, np.array(estimate["beta"])), metric)
                    for j in (0, 1):
                        row = (case, method, run["seed"], trajectory, j + 1, s.time[j], s.frequency[j], s.total[j])
                        rows.append(row)
    columns = ["case", "method", "seed", "trajectory", "joint", "time", "frequency", "total"]
    return pd.DataFrame(rows, columns=columns)
