"""The numeric experiment: N1 to N4 identified from their torques (Section V-B)."""

import logging
from dataclasses import dataclass
from typing import Any

from repro.cnn.dataset import DataSettings, SignalSettings
from repro.cnn.factored import FactoredCNN
from repro.identify.algorithm1 import SearchSettings
from repro.identify.prepare import prepare
from repro.identify.refinement import RefinementSettings
from repro.model.dynamics import rebuild_torque, regressor
from repro.model.parameters import Array
from repro.pipeline.methods import Identifier
from repro.progress import Progress
from repro.settings import NumericSettings
from repro.signals.trajectories import identification_trajectory
from repro.streams import Stream, stream

_LOG = logging.getLogger(__name__)


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
    """Identify every test arm by Algorithm 1, by its refinement, and by the control without the network."""
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
            stream(seed, Stream.REFINE, index),
        )
        arms[name] = {"true": beta.tolist(), "executions_over_threshold": met, "methods": methods}
        _LOG.info("%s: %d of %d executions over the threshold", name, met, e.search.executions)
        progress(index + 1, len(e.numeric.arms))
    return {"variant": e.variant, "seed": seed, "arms": arms}
