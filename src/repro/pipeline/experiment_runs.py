"""The experiment: parameters from the recording of the identification trajectory, validated on T1 to T4."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from repro.cnn.dataset import SignalSettings
from repro.estimators import bounded, consistent
from repro.identify.algorithm1 import ImageMotion
from repro.identify.least_squares import least_squares
from repro.identify.prepare import Prepared, prepare
from repro.model.dynamics import rebuild_torque, regressor
from repro.model.parameters import Array
from repro.pipeline.recordings import Recording
from repro.signals.dct import dct2dev, dct2low
from repro.signals.metric import MetricSettings, metr2ev
from repro.streams import Stream, stream

if TYPE_CHECKING:
    from repro.pipeline.methods import Identifier

#: The one case of the experiment's identifications: parameters come from this motion.
CASE = "ID"


@dataclass(frozen=True)
class Filtered:
    """Signals of a recording after lines 1 to 4 of Algorithm 1.

    Attributes
    ----------
    q, dq, ddq, tau : arrays of shape (2, N)
        Position (rad), velocity (rad/s), acceleration (rad/s^2), torque (N m) of the trajectory proper.
    """

    q: Array
    dq: Array
    ddq: Array
    tau: Array

    @property
    def regressor(self) -> Array:
        """Regressor Y of Eq. 1, shape (2, N, 9)."""
        return regressor(self.q, self.dq, self.ddq)


def filtered(recording: Recording, signals: SignalSettings) -> Filtered:
    """Derivatives and filtered torque, then **cut**: the same filter on torque and motion."""
    h, c_f, reading = signals.h, signals.c_f, signals.reading
    dq = dct2dev(recording.q, h, c_f, reading)
    ddq = dct2dev(dq, h, c_f, reading)
    tau = dct2low(recording.tau, h, c_f, reading)
    proper = slice(recording.program.n1, recording.program.n2)
    return Filtered(recording.q[:, proper], dq[:, proper], ddq[:, proper], tau[:, proper])


def prepare_recording(
    recording: Recording, tau_mean: Array, signals: SignalSettings, image_motion: ImageMotion = "measured"
) -> Prepared:
    """Lines 1 to 12 of Algorithm 1 for a recording of any duration."""
    n1, n2 = recording.program.n1, recording.program.n2
    n, m = n2 - n1, tau_mean.shape[1]
    phase = (np.arange(n) + 0.5) * m / n - 0.5
    mean = np.stack([np.interp(phase, np.arange(m), joint) for joint in tau_mean])
    desired = recording.program.q if image_motion == "desired" else None
    return prepare(recording.q, recording.tau, mean, signals, n1, n2, m / n, desired)


def identify_recording(
    identifier: "Identifier", recording: Recording, tau_mean: Array, signals: SignalSettings, seed: int, true: Array
) -> dict[str, Any]:
    """Algorithm 1 and its refinement on one recording."""
    prepared = prepare_recording(recording, tau_mean, signals, identifier.search.image_motion)
    methods, met = identifier.methods(
        prepared, stream(seed, Stream.EXPERIMENT_SEARCH), stream(seed, Stream.EXPERIMENT_REFINE)
    )
    arm = {"true": true.tolist(), "executions_over_threshold": met, "methods": methods}
    return {"variant": identifier.variant, "seed": seed, "arms": {CASE: arm}}


def least_squares_of(recording: Recording, signals: SignalSettings, true: Array) -> dict[str, Any]:
    """Least squares on the signals that Algorithm 1 sees, in the same form; it has no seed of its own.

    As the paper has it; with no parameter below zero, which is what line 22 asks of Algorithm 1; and with a
    positive-definite inertia matrix. The last two are the methods that a user's own arm is identified by.
    """
    f = filtered(recording, signals)
    y = f.regressor
    solution = least_squares(y, f.tau)
    methods = {
        "least-squares": {
            "beta": solution.beta.tolist(),
            "standard_error": solution.standard_error.tolist(),
            "condition": solution.condition,
        },
        "bounded": {"beta": bounded.solve(y, f.tau).beta.tolist()},
        "consistent": {"beta": consistent.solve(y, f.tau).beta.tolist()},
        "true": {"beta": true.tolist()},
    }
    return {"variant": "least-squares", "seed": 0, "arms": {CASE: {"true": true.tolist(), "methods": methods}}}


def every_seed(runs: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Runs with those that have no seed of their own (seed 0 of variant least-squares) repeated for each seed."""
    seeds = sorted({run["seed"] for run in runs if run["variant"] != "least-squares"}) or [0]
    spread = [{**run, "seed": seed} for run in runs if run["variant"] == "least-squares" for seed in seeds]
    return [dict(run) for run in runs if run["variant"] != "least-squares"] + spread


def score_runs(
    runs: Sequence[Mapping[str, Any]],
    recordings: Sequence[Recording],
    signals: SignalSettings,
    metric: MetricSettings,
) -> pd.DataFrame:
    """Similarity of measured and rebuilt torque for every run and motion.

    Columns ``case, method, seed, joint, time, frequency, total``.
    """
    rows = []
    for recording in recordings:
        f = filtered(recording, signals)
        y = f.regressor
        for run in runs:
            for method, estimate in run["arms"][CASE]["methods"].items():
                s = metr2ev(f.tau, rebuild_torque(y, np.array(estimate["beta"])), metric)
                rows += [
                    (recording.program.name, method, run["seed"], j + 1, s.time[j], s.frequency[j], s.total[j])
                    for j in (0, 1)
                ]
    return pd.DataFrame(rows, columns=["case", "method", "seed", "joint", "time", "frequency", "total"])


def tracking(recording: Recording, metric: MetricSettings) -> pd.DataFrame:
    """How well the arm followed the identification trajectory (Table 8), in the columns of `score_runs`."""
    proper = slice(recording.program.n1, recording.program.n2)
    s = metr2ev(recording.program.q[:, proper], recording.q[:, proper], metric)
    rows = [("tracking", "pd", 0, j + 1, s.time[j], s.frequency[j], s.total[j]) for j in (0, 1)]
    return pd.DataFrame(rows, columns=["case", "method", "seed", "joint", "time", "frequency", "total"])
