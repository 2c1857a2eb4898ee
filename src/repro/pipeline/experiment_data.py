"""Numbers of Figures 18 to 24 and of Tables 8 to 10 from the recordings, the runs and their scores."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from repro.fpga.controller import ControlConstants
from repro.identification.regression import Regression
from repro.model.dynamics import rebuild_torque
from repro.model.parameters import Array
from repro.model.stability import stability_constants
from repro.pipeline.experiment_runs import CASE
from repro.pipeline.figure_data import Curve, curves
from repro.pipeline.recordings import Recording
from repro.pipeline.summary import median_seeds
from repro.signals.dct import spectrum
from repro.signals.kinematics import ArmGeometry, forward_kinematics
from repro.signals.sampling import SignalSettings

#: Methods whose torques the figures show; the literal Algorithm 1 only where parameters are identified.
SHOWN = ("algorithm1+refinement", "least-squares")
SHOWN_ON_ID = ("algorithm1", *SHOWN)
#: Highest frequency drawn, Hz; the filter leaves nothing above.
HIGHEST = 40.0

Runs = Sequence[Mapping[str, Any]]


def shown_estimates(runs: Runs, scores: pd.DataFrame) -> dict[str, Array]:
    """Estimate that stands for each method: of the seed whose similarity on ID is the median."""
    chosen = median_seeds(scores[scores["case"] == CASE].assign(trajectory="ID"))
    estimates = {}
    for run in runs:
        for method, estimate in run["arms"][CASE]["methods"].items():
            if chosen[CASE, method] == run["seed"]:
                estimates[method] = np.array(estimate["beta"], dtype=np.float64)
    return estimates


def _torque_curves(
    f: Regression, estimates: Mapping[str, Array], methods: Iterable[str], h: float, prefix: str, in_frequency: bool
) -> list[Curve]:
    y, n = f.y, f.tau.shape[1]
    series: dict[str, Array] = {"measured": f.tau}
    series |= {method: rebuild_torque(y, estimates[method]) for method in methods}
    x = np.asarray(np.arange(n) / (2 * n * h) if in_frequency else np.arange(n) * h, dtype=np.float64)
    kept = x <= HIGHEST if in_frequency else np.ones(n, dtype=np.bool_)
    parts: list[Curve] = []
    for j in (0, 1):
        for name, tau in series.items():
            y_j = spectrum(tau[j]) if in_frequency else tau[j]
            parts.append((f"{prefix}torque{j + 1}", name, x[kept], y_j[kept]))
    return parts


def _motion_curves(recording: Recording, f: Regression, h: float, prefix: str) -> list[Curve]:
    program = recording.program
    desired = program.q[:, program.n1 : program.n2]
    time = np.asarray(h * np.arange(desired.shape[1]), dtype=np.float64)
    parts = [(f"{prefix}position", f"desired{j + 1}", time, desired[j]) for j in (0, 1)]
    for panel, x in (("position", f.q), ("velocity", f.dq), ("acceleration", f.ddq)):
        parts += [(f"{prefix}{panel}", f"joint{j + 1}", time, x[j]) for j in (0, 1)]
    return parts


def identification_figure(
    recording: Recording, signals: SignalSettings, estimates: Mapping[str, Array], in_frequency: bool = False
) -> pd.DataFrame:
    """Figures 19 and 20: torque of the identification run and its rebuilding, with the motion or as spectra."""
    f = recording.regression(signals)
    parts = _torque_curves(f, estimates, SHOWN_ON_ID, signals.h, "", in_frequency)
    return curves(parts if in_frequency else parts + _motion_curves(recording, f, signals.h, ""))


def validation_figure(
    recordings: Iterable[Recording],
    signals: SignalSettings,
    estimates: Mapping[str, Array],
    in_frequency: bool = False,
) -> pd.DataFrame:
    """Figures 23 and 24: torques of T1 to T4 and their rebuilding, or their spectra."""
    return curves(
        curve
        for recording in recordings
        for curve in _torque_curves(
            recording.regression(signals), estimates, SHOWN, signals.h, f"{recording.program.name} ", in_frequency
        )
    )


def motions_figure(recordings: Iterable[Recording], signals: SignalSettings) -> pd.DataFrame:
    """Figure 22: desired and measured motions of T1 to T4."""
    return curves(
        curve
        for recording in recordings
        for curve in _motion_curves(recording, recording.regression(signals), signals.h, f"{recording.program.name} ")
    )


def paths_figure(recordings: Iterable[Recording], geometry: ArmGeometry) -> pd.DataFrame:
    """Figure 21: path of the tip in T1 to T4, m."""
    parts = []
    for recording in recordings:
        for series, q in (("desired", recording.program.q), ("actual", recording.q)):
            tip = forward_kinematics(q, geometry)[1]
            parts.append((recording.program.name, series, tip[0], tip[1]))
    return curves(parts)


def control_table(tracked: pd.DataFrame, control: ControlConstants, c_f: float) -> pd.DataFrame:
    """Table 8: tracking of the identification trajectory and the constants of the board."""
    return tracked.drop(columns="seed").assign(
        total_sd=0.0, seeds=1, kp=control.kp, kv=control.kv, pwm_khz=np.array(control.pwm_hz) / 1e3, c_f=c_f
    )


def stability_table(estimates: Mapping[str, Array], methods: Sequence[str]) -> pd.DataFrame:
    """Conditions of Appendix A with the parameters of each method.

    Columns ``method, quantity, symbol, value, bound, holds``.
    """
    rows: list[tuple[str, str, str, float, float, bool]] = []
    for method in methods:
        c = stability_constants(estimates[method])
        rows += [
            (method, "Potential energy (Eq. 17)", "rho lambda_Q^min", c.potential, 0.0, c.conditions["potential"]),
            (
                method, "Energy (Eq. 17)",
                "rho lambda_Q^min lambda_M^min / 2 - (epsilon lambda_M^max)^2 / 4",
                c.energy, 0.0, c.conditions["energy"],
            ),
            (
                method, "Dissipation (Eq. 18)",
                "rho epsilon lambda_Q^min (lambda_H^min - epsilon lambda_M^max + gamma lambda lambda_K^min)",
                c.dissipation, c.coupling, c.conditions["dissipation"],
            ),
            (method, "Rate (Eq. 19)", "lambda_R1^min", c.r1_min, c.r2_max, c.conditions["rate"]),
        ]  # fmt: skip
    return pd.DataFrame(rows, columns=["method", "quantity", "symbol", "value", "bound", "holds"])
