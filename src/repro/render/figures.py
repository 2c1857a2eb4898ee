"""Every figure by name, and drawing one from its CSV to PDF and PNG."""

from collections.abc import Callable
from pathlib import Path

import pandas as pd
from matplotlib.figure import Figure

from repro.errors import InputError
from repro.files import read_csv
from repro.render import (
    ablation,
    candidates,
    coverage,
    experiment,
    experiment_setup,
    flow_charts,
    hardware,
    images,
    lines,
    network,
    schematics,
    spread,
    style,
    torques,
    two_link_arm,
    why,
)

#: Figure from the table that holds its numbers; call these inside `style.house_style`.
FIGURES: dict[str, Callable[[pd.DataFrame], Figure]] = {
    "fig01": two_link_arm.schematic,
    "fig02": hardware.hardware,
    "fig03": flow_charts.control,
    "fig04": flow_charts.method,
    "fig05": schematics.subsampling,
    "fig06": lines.motion,
    "fig07": network.network,
    "fig08": images.examples,
    "fig09": lines.torque_distribution,
    "fig10": lines.loss,
    "fig11": images.kernels,
    "fig12": torques.torques_12,
    "fig13": torques.torques_34,
    "fig14": torques.spectra_all,
    "fig15": torques.torques_all,
    "fig16": lines.random_motion,
    "fig17": torques.spectra_all,
    "fig18": experiment_setup.setup,
    "fig19": experiment.identification,
    "fig20": experiment.identification_spectra,
    "fig21": experiment.paths,
    "fig22": experiment.validation_motion,
    "fig23": experiment.validation_torques,
    "fig24": experiment.validation_spectra,
    "spread": spread.spread,
    "why": why.figure,
    "paper_recipe": lines.held_out_losses,
    "coverage": coverage.figure,
    "metric_search": candidates.metric_search,
    "ablation": ablation.figure,
}


def draw(name: str, csv_path: Path, pdf_path: Path, png_path: Path) -> None:
    """Draw one figure from its CSV."""
    if name not in FIGURES:
        raise InputError.at("figure", repr(name), f"one of {', '.join(FIGURES)}")
    frame = read_csv(csv_path)
    with style.house_style():
        try:
            figure = FIGURES[name](frame)
        except InputError as error:
            raise InputError(f"{csv_path}: {error}") from error
        style.save(figure, name, pdf_path, png_path)
