"""The numeric experiment: N1 to N4 identified from their torques (Section V-B)."""

import logging
from typing import Any

from repro.cnn.dataset import SignalSettings
from repro.identification.algorithm1.listing import filtered, prepare
from repro.identification.algorithm1.run import Algorithm1
from repro.identification.methods.interface import as_json
from repro.model.dynamics import rebuild_torque, regressor
from repro.model.parameters import Array
from repro.progress import Progress
from repro.settings import NumericSettings
from repro.signals.trajectories import identification_trajectory
from repro.streams import Stream, stream

_LOG = logging.getLogger(__name__)


def identify_arms(
    algorithm1: Algorithm1, signals: SignalSettings, numeric: NumericSettings, tau_mean: Array, seed: int
) -> dict[str, Any]:
    """Identify every test arm by Algorithm 1, by its refinement, and by the refinement's control.

    For each arm its true parameters, and for each method the estimate, its similarity and its cost in images. Mean
    torque of the training data of shape (2, N), N m.
    """
    margin, executions = numeric.margin, algorithm1.search.executions
    recorded = identification_trajectory(signals.duration, signals.h, margin)
    y_recorded = regressor(recorded.q, recorded.dq, recorded.ddq)
    progress = Progress(f"{algorithm1.variant} image, seed {seed}")
    arms: dict[str, Any] = {}
    for index, (name, beta) in enumerate(numeric.arms.items()):
        tau = rebuild_torque(y_recorded, beta)
        measured = filtered(recorded.q, tau, signals, margin, margin + tau_mean.shape[-1])
        streams = (stream(seed, kind, index) for kind in (Stream.SEARCH, Stream.REFINE))
        found, met = algorithm1.run(prepare(measured, tau_mean, signals), *streams)
        arms[name] = {"true": beta.tolist(), "executions_over_threshold": met, "methods": as_json(found)}
        _LOG.info("%s: %d of %d executions over the threshold", name, met, executions)
        progress(index + 1, len(numeric.arms))
    return {"variant": algorithm1.variant, "seed": seed, "arms": arms}
