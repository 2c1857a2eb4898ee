"""The experiment on the simulated arm: torques, spectra, motions and paths (Fig. 19-24)."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial

import pandas as pd
from matplotlib.figure import Figure

from repro.exhibits import style
from repro.render.lines import JOINTS, MOTION, TIME, curves_of, plot_panel
from repro.render.torques import page, spectrum_panels, torque_panels
from repro.signals.programs import VALIDATION

#: Motions on which the identified parameters are validated (Section VI).
CASES = tuple(VALIDATION)

#: Series of each panel of a motion, the desired position below the one reached.
_TRACKED = {"position": ("desired1", "desired2", *JOINTS), "velocity": JOINTS, "acceleration": JOINTS}

#: Title of each torque panel of the identification experiment, and of the validation experiments.
_IDENTIFICATION = {"torque1": "Joint 1", "torque2": "Joint 2"}
_VALIDATION = {f"{case} torque{j}": f"{case}, joint {j}" for case in CASES for j in (1, 2)}


def _compared(frame: pd.DataFrame) -> tuple[str, ...]:
    """Series of the torque panels: the measured one, then the methods that the table holds."""
    found = set(frame["series"])
    return ("measured", *(name for name in style.METHODS if name in found))


def _torques(frame: pd.DataFrame, titles: Mapping[str, str], draw: Callable[..., None]) -> Figure:
    """Measured and rebuilt signals, a column for each joint."""
    curves = curves_of(frame, dict.fromkeys(titles, _compared(frame)))
    figure = page(len(titles))
    draw(figure, curves, titles, legend_title=style.SIMULATED)
    return figure


def identification(frame: pd.DataFrame) -> Figure:
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


def identification_spectra(frame: pd.DataFrame) -> Figure:
    """DCT-II of the torques of the identification trajectory (Fig. 20)."""
    return _torques(frame, _IDENTIFICATION, spectrum_panels)


def paths(frame: pd.DataFrame) -> Figure:
    """Desired and actual paths of the tip on the validation motions (Fig. 21)."""
    curves = curves_of(frame, dict.fromkeys(CASES, ("actual", "desired")))
    figure = style.new_figure(style.PAGE, 2.35)
    panels = figure.subplots(1, len(CASES))
    for axes, case in zip(panels, CASES, strict=True):
        plot_panel(axes, curves[case])
        axes.set(title=case, xlabel="$x$ (m)", aspect="equal", adjustable="datalim")
        axes.locator_params(axis="both", nbins=4)
    panels[0].set_ylabel("$y$ (m)")
    style.legend_above(figure, panels[0], 2, style.SIMULATED)
    return figure


def validation_motion(frame: pd.DataFrame) -> Figure:
    """Validation motions of both joints (Fig. 22)."""
    wanted: dict[str, Sequence[str]] = {f"{case} {panel}": _TRACKED[panel] for panel in MOTION for case in CASES}
    curves = curves_of(frame, wanted)
    figure = style.new_figure(style.PAGE, 4.3)
    grid = figure.subplots(len(MOTION), len(CASES), sharex="col")
    for row, (panel, label) in zip(grid, MOTION.items(), strict=True):
        for axes, case in zip(row, CASES, strict=True):
            plot_panel(axes, curves[f"{case} {panel}"])
        row[0].set_ylabel(label)
    for axes, case in zip(grid[0], CASES, strict=True):
        axes.set_title(case)
    for axes in grid[-1]:
        axes.set_xlabel(TIME)
    figure.align_ylabels()
    style.legend_above(figure, grid[0, 0], 4, style.SIMULATED)
    return figure


def validation_torques(frame: pd.DataFrame) -> Figure:
    """Torques of the validation motions, rebuilt by each method (Fig. 23)."""
    return _torques(frame, _VALIDATION, torque_panels)


def validation_spectra(frame: pd.DataFrame) -> Figure:
    """DCT-II of the torques of the validation motions (Fig. 24)."""
    return _torques(frame, _VALIDATION, partial(spectrum_panels, by_row=True))
