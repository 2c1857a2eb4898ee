"""Kept numbers of every figure and table, and how tests draw and lay them out."""

import itertools
from functools import partial
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.transforms import Bbox

from repro.drawing import style
from repro.exhibits import catalogue, declare
from repro_studies.interpretations import INTERPRETATIONS, ablation_figure

ROOT = Path(__file__).resolve().parents[2]
REFERENCE = ROOT / "docs/reference/tables"
#: Numbers of figures: of the golden run, of long ones some rows, or else of the reference.
FIGURE_NUMBERS = (ROOT / "tests/golden/figures", ROOT / "docs/reference/figures")
#: Methods with a network of our training, of the paper's, and of the paper's ranges, too.
RECIPES = ("algorithm1", "algorithm1+paper-recipe", "algorithm1+paper-recipe-ranges")

EXHIBITS = {(each.kind, each.name): each for each in catalogue.EXHIBITS}
#: Drawings and layouts by the name of the exhibit.
FIGURES = {e.name: e.draw for e in catalogue.EXHIBITS if e.kind == "figure"}
LAYOUTS = {e.name: e.draw for e in catalogue.EXHIBITS if e.kind == "table"}
WITHOUT_AXES = {"fig01", "fig02", "fig03", "fig04", "fig07", "fig18"}
#: Tables that go on over pages.
LONG = ("audit",)


def readings_frame() -> pd.DataFrame:
    """Numbers of each reading: one far below the others on the numeric arms, another one on the simulated arm."""
    rows = []
    for i, reading in enumerate(INTERPRETATIONS.values()):
        numeric = (0.3012, 0.1, 0.2847) if reading.name == "rad/s" else (0.975, 0.9312, 0.968)
        arm = (0.9512, 0.4811, 0.9667) if reading.name == "SI units" else (0.953, 0.9411, 0.9667)
        arm = (0.9612, 0.9222, *arm)
        shares = [share + 0.0007 * (i % 5) for share in (*numeric, *arm)]
        rows.append((reading.question, reading.name, 40_000 + i, 1.25e-4 * (1 + i), *shares))
    of_arm = ["arm_id", "arm_validation", "arm_refined", "arm_least_squares", "arm_true"]
    shares = ["id_mean", "id_lowest", "validation_mean", *of_arm]
    return pd.DataFrame(rows, columns=["question", "reading", "steps", "held_out_loss", *shares])


def index_frame(shape: dict[str, int]) -> pd.DataFrame:
    return pd.DataFrame(itertools.product(*(range(n) for n in shape.values())), columns=list(shape))


def examples_frame() -> pd.DataFrame:
    pixels = index_frame({"row": 12, "column": 12})
    shade = (pixels["row"] * 12 + pixels["column"]) / 143
    pixels = pixels.assign(red=shade, green=1 - shade, blue=0.5)
    return pd.concat([pixels.assign(kind=k, image=i) for k in ("Mp", "Mn") for i in "abcdefghi"], ignore_index=True)


def kernels_frame() -> pd.DataFrame:
    frames = []
    for layer, size, inputs in (("conv1", 9, 2), ("conv2", 5, 10), ("conv3", 3, 10)):
        frame = index_frame({"input": inputs, "output": 10, "row": size, "column": size}).assign(layer=layer)
        frames.append(frame.assign(power=np.linspace(0.0, 1.0, len(frame))))
    return pd.concat(frames, ignore_index=True)


#: Of the ablation, which takes hours, no numbers are kept; of whole images and kernels, no rows can be left out.
MADE_UP = {"ablation": lambda: ablation_figure(readings_frame()), "fig08": examples_frame, "fig11": kernels_frame}


def figure_numbers(name: str) -> pd.DataFrame:
    """Numbers of a figure."""
    if name in MADE_UP:
        return MADE_UP[name]()
    return pd.read_csv(next(file for folder in FIGURE_NUMBERS if (file := folder / f"{name}.csv").exists()))


#: Numbers of the reference run, digit by digit; it has no ablation, which is made on request.
as_text = partial(pd.read_csv, dtype=str, keep_default_na=False)
TABLES = {name: partial(as_text, REFERENCE / f"{name}.csv") for name in LAYOUTS} | {"ablation": readings_frame}


def written(kind: str, folder: Path, name: str, frame: pd.DataFrame, *endings: str) -> list[Path]:
    """Files of an exhibit that are made of its CSV."""
    out = {ending: folder / f"{name}.{ending}" for ending in ("csv", *endings)}
    frame.to_csv(out["csv"], index=False)
    declare.show(EXHIBITS[kind, name], out)
    return [out[ending] for ending in endings]


def drawn(folder: Path, name: str, frame: pd.DataFrame) -> tuple[bytes, ...]:
    return tuple(path.read_bytes() for path in written("figure", folder, name, frame, "pdf", "png"))


def laid_out(folder: Path, name: str, frame: pd.DataFrame) -> tuple[str, ...]:
    return tuple(path.read_text(encoding="utf-8") for path in written("table", folder, name, frame, "tex", "md"))


def made(name: str, frame: pd.DataFrame) -> Figure:
    with style.house_style():
        return FIGURES[name](frame)


def shown_texts(figure: Figure) -> list[tuple[Text, Bbox]]:
    """Every text that can be seen, with its box; ticks outside the view are not drawn."""
    hidden = set()
    for axes in figure.findobj(mpl.axes.Axes):
        for axis in (axes.xaxis, axes.yaxis):
            low, high = sorted(axis.get_view_interval())
            for tick in (*axis.get_major_ticks(), *axis.get_minor_ticks()):
                if not low - 1e-9 <= tick.get_loc() <= high + 1e-9 or not axes.axison:
                    hidden |= {tick.label1, tick.label2}
    texts = [t for t in figure.findobj(Text) if t.get_text().strip() and t.get_visible() and t not in hidden]
    axes_off = [a for a in figure.findobj(mpl.axes.Axes) if not a.axison]
    labels_off = {label for a in axes_off for label in (a.xaxis.label, a.yaxis.label)}
    return [(t, Text.get_window_extent(t)) for t in texts if t not in labels_off and t.figure is not None]
