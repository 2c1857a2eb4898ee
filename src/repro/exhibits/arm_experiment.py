"""The experiment on the simulated arm: Tables 8 to 10, Figures 19 to 24, and the conditions of the appendix."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from repro.exhibits import style
from repro.exhibits.declare import ARM, EXPERIMENT, Inputs, figure, table
from repro.exhibits.markup import Table, Text, formula, number, plain, scientific
from repro.exhibits.panels import (
    JOINTS,
    MOTION,
    TIME,
    Curve,
    curves_of,
    long_table,
    page,
    plot_panel,
    spectrum_panels,
    torque_panels,
)
from repro.exhibits.result_tables import heading_of, methods_of, one_row, similarities, with_unit
from repro.identification.regression import Regression
from repro.model.dynamics import ArmGeometry, forward_kinematics, rebuild_torque
from repro.model.parameters import Array
from repro.model.stability import stability_constants
from repro.pipeline.experiment import (
    Recording,
    control_constants,
    mechanical_parameters,
    program_settings,
    read_recordings,
)
from repro.pipeline.identifications import CASE, SCORES, read_identifications, read_scores, tracking
from repro.pipeline.job import Config
from repro.pipeline.summary import experiment_table, median_seeds, parameter_table
from repro.settings import metric_settings, signal_settings
from repro.signals.dct import SignalSettings, spectrum
from repro.signals.programs import PROGRAMS, SPAN, VALIDATION

#: Methods whose torques the figures show; the literal Algorithm 1 only where parameters are identified.
SHOWN = ("algorithm1+refinement", "least-squares")
SHOWN_ON_ID = ("algorithm1", *SHOWN)
#: Highest frequency drawn, Hz; the filter leaves nothing above.
HIGHEST = 40.0
_TABLE_10 = "on the identification motion and the validation motions, simulated experiment"
Runs = Sequence[Mapping[str, Any]]


def _recordings(inputs: Inputs, config: Config) -> list[Recording]:
    return read_recordings(inputs["captures"], config)


def _runs(inputs: Inputs) -> list[dict[str, Any]]:
    return read_identifications(inputs["identifications"])


def _scores(inputs: Inputs) -> pd.DataFrame:
    return read_scores(inputs["scores"], SCORES)


def shown_estimates(runs: Runs, scores: pd.DataFrame) -> dict[str, Array]:
    """Estimate that stands for each method: of the seed whose similarity on ID is the median."""
    chosen = median_seeds(scores[scores["case"] == CASE].assign(trajectory="ID"))
    estimates = {}
    for run in runs:
        for method, estimate in run["arms"][CASE]["methods"].items():
            if chosen[CASE, method] == run["seed"]:
                estimates[method] = np.array(estimate["beta"], dtype=np.float64)
    return estimates


def control_layout(frame: pd.DataFrame) -> Table:
    """Constants of the embedded system and how well the position follows (Table 8)."""
    rows = []
    for joint in (1, 2):
        row = one_row(frame, {"joint": joint})
        spread = 100.0 * float(row["total_sd"]) if row["seeds"] > 1 else None
        cells = [formula(f"q{joint}"), number(100.0 * float(row["total"]), 2, spread)]
        cells += [number(float(row["kp"]), 4), number(float(row["kv"]), 4)]
        rows.append([*cells, number(float(row["pwm_khz"]), 0), scientific(float(row["c_f"]), 0)])
    gain = Text("$K_{p}$", "Kp"), Text("$K_{v}$", "Kv")
    header = (
        plain("Joint"),
        plain("metr2ev (%)"),
        with_unit(gain[0], "N m/rad"),
        with_unit(gain[1], "N m/rad"),
        Text(r"$f_{\mathrm{PWM}}$~(kHz)", "f PWM (kHz)"),
        with_unit(Text("$c_{f}$", "c_f"), "s^2"),
    )
    caption = plain(
        "Constants of the simulated board and similarity of the desired and the simulated position on the "
        "identification trajectory. Kv is for the change of position over one sample."
    )
    return Table(caption, "lrrrrr", header, [(None, rows)])


@table(8, "Position control of the board", EXPERIMENT, control_layout, inputs=("ID",), sections=(*ARM, "metric"))
def table08(inputs: Inputs, config: Config) -> pd.DataFrame:
    """Constants of the simulated board and similarity of the desired and the simulated position on the identification
    trajectory (Table 8).
    """
    (recording,) = _recordings(inputs, config)
    tracked = tracking(recording, metric_settings(config))
    control, c_f = control_constants(config), config["signals"]["filter_coefficient"]
    pwm_khz = np.array(control.pwm_hz) / 1e3
    constants = tracked.drop(columns="seed").assign(total_sd=0.0, seeds=1, kp=control.kp, kv=control.kv)
    return constants.assign(pwm_khz=pwm_khz, c_f=c_f)


#: Methods of Table 9 that stand side by side.
SIDE_BY_SIDE = ("algorithm1", "algorithm1+refinement", "least-squares")


def parameter_layout(frame: pd.DataFrame) -> Table:
    """Parameters of the simulated arm as identified by each method (Table 9)."""
    methods = [method for method in methods_of(frame) if method in SIDE_BY_SIDE]
    left_out = len(methods_of(frame)) - len(methods)
    repeated = bool((frame["estimate_sd"] > 0).any())
    rows = []
    for name, si in dict(zip(frame["parameter"], frame["unit"], strict=True)).items():
        found = [one_row(frame, {"method": method, "parameter": name}) for method in methods]
        cells = [with_unit(formula(name), si), number(float(found[0]["true"]), 4)]
        cells += [number(float(row["estimate"]), 4, float(row["estimate_sd"]) if repeated else None) for row in found]
        rows.append(cells)
    spread = ", ± the standard deviation over the seeds" if repeated else ""
    rest = f" {left_out} further methods are in the CSV." if left_out else ""
    caption = plain(f"True and identified parameters of the simulated arm: median seed{spread}.{rest}")
    header = [plain("Parameter"), plain("True"), *(heading_of(method) for method in methods)]
    return Table(caption, "lr" + "r" * len(methods), header, [(None, rows)])


@table(9, "Parameters of the arm", EXPERIMENT, parameter_layout, inputs=("arm",), trained="claims")
def table09(inputs: Inputs, _: Config) -> pd.DataFrame:
    """True parameters of the simulated arm and the parameters identified by each method, median seed (the paper's Table
    9 is an image).
    """
    on_id = _scores(inputs).query("case == @CASE").assign(trajectory="ID")
    table = parameter_table(_runs(inputs), on_id, (CASE,))
    return table[table["method"] != "true"].reset_index(drop=True)


@table(
    10,
    f"Similarity on the identification run and on {SPAN}",
    EXPERIMENT,
    lambda frame: similarities(frame, PROGRAMS, _TABLE_10),
    inputs=("arm",),
    trained="claims",
)
def table10(inputs: Inputs, _: Config) -> pd.DataFrame:
    """Similarity of the torques measured in the simulated experiment and rebuilt from the parameters of each method, on
    the identification trajectory and on the validation motions: the median of the seeds and the spread over the seeds
    (Table 10). The true parameters' own score is the ceiling; refinement is an extension of ours.
    """
    return experiment_table(_scores(inputs), CASE)


def stability_table(estimates: Mapping[str, Array], methods: Sequence[str]) -> pd.DataFrame:
    """Conditions of Appendix A with the parameters of each method."""
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


def stability_layout(frame: pd.DataFrame) -> Table:
    """Conditions for stability of the appendix with the parameters of each method."""
    blocks = []
    for method in methods_of(frame):
        chosen = frame.loc[frame["method"] == method, ["quantity", "symbol", "value", "bound", "holds"]]
        rows = [
            (
                plain(quantity),
                formula(symbol),
                scientific(value, 4),
                scientific(bound, 4),
                plain("yes" if holds else "no"),
            )
            for quantity, symbol, value, bound, holds in chosen.itertuples(index=False)
        ]
        blocks.append((heading_of(method), rows))
    caption = plain(
        "Conditions for input-to-state stability (appendix) with the parameters identified on the simulated arm; a "
        "condition holds if its value exceeds its bound."
    )
    header = tuple(plain(name) for name in ("Condition", "Symbol", "Value", "Bound", "Holds"))
    return Table(caption, "llrrl", header, blocks)


@table(
    "stability",
    "Conditions of the appendix",
    EXPERIMENT,
    stability_layout,
    target="stability",
    inputs=("arm",),
    sections=("arm",),
)
def stability(inputs: Inputs, config: Config) -> pd.DataFrame:
    """Conditions of the appendix for input-to-state stability with the parameters that each method identified on the
    simulated arm.
    """
    estimates = {**shown_estimates(_runs(inputs), _scores(inputs)), "appendix": mechanical_parameters(config)}
    return stability_table(estimates, ("algorithm1", *SHOWN, "true", "appendix"))


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


def identification_curves(
    recording: Recording, signals: SignalSettings, estimates: Mapping[str, Array], in_frequency: bool = False
) -> pd.DataFrame:
    """Figures 19 and 20: torque of the identification run and its rebuilding, with the motion or as spectra."""
    f = recording.regression(signals)
    parts = _torque_curves(f, estimates, SHOWN_ON_ID, signals.h, "", in_frequency)
    return long_table(parts if in_frequency else parts + _motion_curves(recording, f, signals.h, ""))


def validation_curves(
    recordings: Iterable[Recording], signals: SignalSettings, estimates: Mapping[str, Array], in_frequency: bool = False
) -> pd.DataFrame:
    """Figures 23 and 24: torques of T1 to T4 and their rebuilding, or their spectra."""
    return long_table(
        curve
        for recording in recordings
        for curve in _torque_curves(
            recording.regression(signals), estimates, SHOWN, signals.h, f"{recording.program.name} ", in_frequency
        )
    )


def tip_paths(recordings: Iterable[Recording], geometry: ArmGeometry) -> pd.DataFrame:
    """Figure 21: path of the tip in T1 to T4, m."""
    parts = []
    for recording in recordings:
        for series, q in (("desired", recording.program.q), ("actual", recording.q)):
            tip = forward_kinematics(q, geometry)[1]
            parts.append((recording.program.name, series, tip[0], tip[1]))
    return long_table(parts)


def _identification(inputs: Inputs, config: Config, in_frequency: bool) -> pd.DataFrame:
    (recording,), estimates = _recordings(inputs, config), shown_estimates(_runs(inputs), _scores(inputs))
    return identification_curves(recording, signal_settings(config), estimates, in_frequency)


def _validation(inputs: Inputs, config: Config, in_frequency: bool) -> pd.DataFrame:
    recordings, estimates = _recordings(inputs, config), shown_estimates(_runs(inputs), _scores(inputs))
    return validation_curves(recordings, signal_settings(config), estimates, in_frequency)


#: Motions on which the identified parameters are validated (Section VI).
VALIDATION_MOTIONS = tuple(VALIDATION)
#: Series of each panel of a motion, the desired position below the one reached.
_TRACKED = {"position": ("desired1", "desired2", *JOINTS), "velocity": JOINTS, "acceleration": JOINTS}
#: Title of each torque panel of the identification experiment, and of the validation experiments.
_IDENTIFICATION = {"torque1": "Joint 1", "torque2": "Joint 2"}
_VALIDATION = {f"{case} torque{j}": f"{case}, joint {j}" for case in VALIDATION_MOTIONS for j in (1, 2)}


def _compared(frame: pd.DataFrame) -> tuple[str, ...]:
    """Series of the torque panels: the measured one, then the methods that the table holds."""
    found = set(frame["series"])
    return ("measured", *(name for name in style.METHODS if name in found))


def _compared_torques(frame: pd.DataFrame, titles: Mapping[str, str], draw: Callable[..., None]) -> Figure:
    """Measured and rebuilt signals, a column for each joint."""
    curves = curves_of(frame, dict.fromkeys(titles, _compared(frame)))
    figure = page(len(titles))
    draw(figure, curves, titles, legend_title=style.SIMULATED)
    return figure


def draw_identification(frame: pd.DataFrame) -> Figure:
    """Torques on the identification trajectory, rebuilt by each method, and the motion (Fig. 19)."""
    torque_series = dict.fromkeys(_IDENTIFICATION, _compared(frame))
    curves = curves_of(frame, {**torque_series, **_TRACKED})
    figure = style.new_figure(style.PAGE, 4.4)
    upper, lower = figure.subfigures(2, 1, squeeze=False, height_ratios=(1.15, 1.0))[:, 0]
    torque_panels(upper, curves, _IDENTIFICATION, style.SIMULATED)
    panels = lower.subplots(1, 3)
    for axes, (panel, label) in zip(panels, MOTION.items(), strict=True):
        plot_panel(axes, curves[panel])
        axes.set(xlabel=TIME, ylabel=label)
    style.legend_above(lower, panels[0], 4)
    return figure


def draw_paths(frame: pd.DataFrame) -> Figure:
    """Desired and actual paths of the tip on the validation motions (Fig. 21)."""
    curves = curves_of(frame, dict.fromkeys(VALIDATION_MOTIONS, ("actual", "desired")))
    figure = style.new_figure(style.PAGE, 2.35)
    panels = figure.subplots(1, len(VALIDATION_MOTIONS))
    for axes, case in zip(panels, VALIDATION_MOTIONS, strict=True):
        plot_panel(axes, curves[case])
        axes.set(title=case, xlabel="$x$ (m)", aspect="equal", adjustable="datalim")
        axes.locator_params(axis="both", nbins=4)
    panels[0].set_ylabel("$y$ (m)")
    style.legend_above(figure, panels[0], 2, style.SIMULATED)
    return figure


def draw_motions(frame: pd.DataFrame) -> Figure:
    """Validation motions of both joints (Fig. 22)."""
    wanted: dict[str, Sequence[str]] = {
        f"{case} {panel}": _TRACKED[panel] for panel in MOTION for case in VALIDATION_MOTIONS
    }
    curves = curves_of(frame, wanted)
    figure = style.new_figure(style.PAGE, 4.3)
    grid = figure.subplots(len(MOTION), len(VALIDATION_MOTIONS), sharex="col")
    for row, (panel, label) in zip(grid, MOTION.items(), strict=True):
        for axes, case in zip(row, VALIDATION_MOTIONS, strict=True):
            plot_panel(axes, curves[f"{case} {panel}"])
        row[0].set_ylabel(label)
    for axes, case in zip(grid[0], VALIDATION_MOTIONS, strict=True):
        axes.set_title(case)
    for axes in grid[-1]:
        axes.set_xlabel(TIME)
    figure.align_ylabels()
    style.legend_above(figure, grid[0, 0], 4, style.SIMULATED)
    return figure


@figure(
    19,
    "Torques and motion of the identification run",
    EXPERIMENT,
    draw_identification,
    inputs=("ID", "arm"),
    sections=ARM,
)
def fig19(inputs: Inputs, config: Config) -> pd.DataFrame:
    """Simulated experiment on the identification trajectory: the torque measured and the torques rebuilt from the
    parameters of each method, with the position, velocity and acceleration of the joints (Fig. 19).
    """
    return _identification(inputs, config, in_frequency=False)


@figure(
    20,
    "Spectra of the identification run's torques",
    EXPERIMENT,
    partial(_compared_torques, titles=_IDENTIFICATION, draw=spectrum_panels),
    inputs=("ID", "arm"),
    sections=ARM,
)
def fig20(inputs: Inputs, config: Config) -> pd.DataFrame:
    """DCT-II spectra of the torques of Fig. 19, simulated experiment (Fig. 20)."""
    return _identification(inputs, config, in_frequency=True)


@figure(21, f"Paths of the tip in {SPAN}", EXPERIMENT, draw_paths, inputs=("validation",), sections=ARM)
def fig21(inputs: Inputs, config: Config) -> pd.DataFrame:
    """Desired and actual path of the tip on the validation motions of the simulated arm (Fig. 21)."""
    return tip_paths(_recordings(inputs, config), program_settings(config).geometry)


@figure(22, f"Motions of {SPAN}", EXPERIMENT, draw_motions, inputs=("validation",), sections=ARM)
def fig22(inputs: Inputs, config: Config) -> pd.DataFrame:
    """Position, velocity and acceleration on the validation motions of the simulated arm (Fig. 22)."""
    signals = signal_settings(config)
    return long_table(
        curve
        for one in _recordings(inputs, config)
        for curve in _motion_curves(one, one.regression(signals), signals.h, f"{one.program.name} ")
    )


@figure(
    23,
    f"Torques of {SPAN}",
    EXPERIMENT,
    partial(_compared_torques, titles=_VALIDATION, draw=torque_panels),
    inputs=("validation", "arm"),
    sections=ARM,
)
def fig23(inputs: Inputs, config: Config) -> pd.DataFrame:
    """Torques measured on the validation motions of the simulated arm and rebuilt from the parameters of each method
    (Fig. 23).
    """
    return _validation(inputs, config, in_frequency=False)


@figure(
    24,
    f"Spectra of the torques of {SPAN}",
    EXPERIMENT,
    partial(_compared_torques, titles=_VALIDATION, draw=partial(spectrum_panels, by_row=True)),
    inputs=("validation", "arm"),
    sections=ARM,
)
def fig24(inputs: Inputs, config: Config) -> pd.DataFrame:
    """DCT-II spectra of the torques of Fig. 23, simulated experiment; each row ends with the last band that matters in
    it (Fig. 24).
    """
    return _validation(inputs, config, in_frequency=True)
