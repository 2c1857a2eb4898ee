"""The numeric experiment: N1 to N4 identified from their torques, rebuilt and validated (Section V-B)."""

import logging
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from repro.cnn.dataset import DataSettings
from repro.cnn.priors import sample_beta
from repro.errors import InputError
from repro.files import read_csv
from repro.identification.algorithm1.preprocessing import filtered, prepare
from repro.identification.least_squares import METHODS
from repro.identification.method import BASELINES, as_json
from repro.identification.regression import Regression
from repro.identification.scores import score
from repro.model.dynamics import inverse_dynamics, rebuild_torque, regressor
from repro.model.parameters import Array
from repro.progress import Progress
from repro.settings import NumericSettings
from repro.signals.dct import SignalSettings
from repro.signals.metric import MetricSettings
from repro.signals.trajectories import Motion, identification_trajectory, random_trajectory, sample_times
from repro.streams import Stream, stream

#: Arms averaged for the mean training torque of fit2trt.
MEAN_ARMS = 10_000


def mean_training_torque(signals: SignalSettings, data: DataSettings, seed: int) -> Array:
    """Mean torque of the training data along the identification trajectory (centre of Fig. 9)."""
    motion = identification_trajectory(signals.duration, signals.h)
    beta = sample_beta(stream(seed, Stream.TRAINING_ARMS), MEAN_ARMS, data.prior).mean(0)
    return inverse_dynamics(motion.q, motion.dq, motion.ddq, beta)


def read_mean_torque(path: str, signals: SignalSettings) -> Array:
    """Mean training torque of a file, an array of shape (2, N), checked for length and finite numbers."""
    columns, samples = ("joint1", "joint2"), sample_times(signals.duration, signals.h).size
    table = read_csv(Path(path), columns)[list(columns)].apply(pd.to_numeric, errors="coerce")
    if len(table) != samples:
        raise InputError.at(f"{path}: rows", len(table), f"{samples}, one for each sample of the trajectory")
    wrong = ~np.isfinite(table.to_numpy())
    if wrong.any():
        line, column = np.argwhere(wrong)[0]
        raise InputError.at(f"{path}: line {line + 2}: {columns[column]}", "no finite number", "a torque in N m")
    tau: Array = table.to_numpy(dtype=np.float64).T
    return tau


def validation_motion(signals: SignalSettings, numeric: NumericSettings, seed: int) -> Motion:
    """Random trajectory that the estimates of a seed are validated on (Fig. 16)."""
    rng = stream(seed, Stream.VALIDATION)
    duration = numeric.validation_samples * signals.h
    return random_trajectory(rng, duration, signals.h, signals.c_f, numeric.validation_reading)


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
    """Similarity of the numeric torques and their rebuilding, for every seed."""
    frames = []
    for run in identifications:
        for trajectory in ("ID", "validation"):
            motion = motion_of(trajectory, signals, numeric, run["seed"])
            y = regressor(motion.q, motion.dq, motion.ddq)
            for case, arm in run["arms"].items():
                tau = rebuild_torque(y, np.array(arm["true"]))
                of_arm = score(y, tau, arm["methods"], metric)
                frames.append(of_arm.assign(case=case, seed=run["seed"], trajectory=trajectory))
    columns = ["case", "method", "seed", "trajectory", "joint", "time", "frequency", "total"]
    return pd.concat(frames, ignore_index=True)[columns]


if TYPE_CHECKING:
    from repro.identification.algorithm1.refinement import Algorithm1

_LOG = logging.getLogger(__name__)


def identify_arms(
    algorithm1: "Algorithm1", signals: SignalSettings, numeric: NumericSettings, tau_mean: Array, seed: int
) -> dict[str, Any]:
    """Identify every test arm by Algorithm 1, by its refinement, and by the refinement's controls.

    For each arm its true parameters, and for each method the estimate, its similarity and its cost in images. Mean
    torque of the training data of shape (2, N), N m.
    """
    executions = algorithm1.search.executions
    progress = Progress(f"{algorithm1.variant} image, seed {seed}")
    arms: dict[str, Any] = {}
    for index, (name, measured) in enumerate(regressions(signals, numeric).items()):
        streams = (stream(seed, kind, index) for kind in (Stream.SEARCH, Stream.REFINE, Stream.UNIFORM_SEARCH))
        found, met = algorithm1.run(prepare(measured, tau_mean, signals), *streams)
        arms[name] = {
            "true": numeric.arms[name].tolist(),
            "executions_over_threshold": met,
            "methods": as_json(found),
        }
        _LOG.info("%s: %d of %d executions over the threshold", name, met, executions)
        progress(index + 1, len(numeric.arms))
    return {"variant": algorithm1.variant, "seed": seed, "arms": arms}


def regressions(signals: SignalSettings, numeric: NumericSettings) -> dict[str, Regression]:
    """Filtered torque and motion of every test arm on the identification trajectory, cut out of the recorded margin."""
    samples, margin = sample_times(signals.duration, signals.h).size, numeric.margin
    recorded = identification_trajectory(signals.duration, signals.h, margin)
    y = regressor(recorded.q, recorded.dq, recorded.ddq)
    return {
        name: filtered(recorded.q, rebuild_torque(y, beta), signals, margin, margin + samples)
        for name, beta in numeric.arms.items()
    }


#: Least squares that the numeric tests are identified by. Positive-definite inertia is left out: N2 and N3 violate it.
LEAST_SQUARES = ("least-squares", "bounded")


def least_squares_of_arms(signals: SignalSettings, numeric: NumericSettings) -> dict[str, Any]:
    """Identify every test arm by least squares on the signals of Algorithm 1."""
    arms = {}
    for name, regression in regressions(signals, numeric).items():
        found = {method: METHODS[BASELINES[method]].estimate(regression) for method in LEAST_SQUARES}
        arms[name] = {"true": numeric.arms[name].tolist(), "methods": as_json(found)}
    return {"variant": "least-squares", "seed": 0, "arms": arms}
