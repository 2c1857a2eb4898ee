"""The numeric experiment: N1 to N4 identified from their torques (Section V-B)."""

import logging
from typing import Any

from repro.cnn.dataset import SignalSettings
from repro.identify.prepare import prepare
from repro.model.dynamics import rebuild_torque, regressor
from repro.model.parameters import Array
from repro.pipeline.methods import Identifier
from repro.progress import Progress
from repro.settings import NumericSettings
from repro.signals.trajectories import identification_trajectory
from repro.streams import Stream, stream

_LOG = logging.getLogger(__name__)


def identify_arms(
    identifier: Identifier, signals: SignalSettings, numeric: NumericSettings, tau_mean: Array, seed: int
) -> dict[str, Any]:
    """Identify every test arm by Algorithm 1, by its refinement, and by the refinement's control.

    For each arm its true parameters, and for each method the estimate, its similarity and its cost in images. Mean
    torque of the training data of shape (2, N), N m.
    """
    margin, executions = numeric.margin, identifier.search.executions
    recorded = identification_trajectory(signals.duration, signals.h, margin)
    y_recorded = regressor(recorded.q, recorded.dq, recorded.ddq)
    progress = Progress(f"{identifier.variant} image, seed {seed}")
    arms: dict[str, Any] = {}
    for index, (name, beta) in enumerate(numeric.arms.items()):
        tau = rebuild_torque(y_recorded, beta)
        prepared = prepare(recorded.q, tau, tau_mean, signals, margin, margin + tau_mean.shape[-1])
        streams = (stream(seed, kind, index) for kind in (Stream.SEARCH, Stream.REFINE))
        methods, met = identifier.methods(prepared, *streams)
        arms[name] = {"true": beta.tolist(), "executions_over_threshold": met, "methods": methods}
        _LOG.info("%s: %d of %d executions over the threshold", name, met, executions)
        progress(index + 1, len(numeric.arms))
    return {"variant": identifier.variant, "seed": seed, "arms": arms}
