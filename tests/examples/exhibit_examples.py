"""Examples of the numbers of every figure and table, and how tests draw and lay them out."""

import itertools
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import matplotlib as mpl
import numpy as np
import pandas as pd
from factorial_example import factorial_scores
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.transforms import Bbox
from print_compatible_example import guess_scores
from study_example import outcomes

from repro.cnn.architecture import NetworkSettings
from repro.drawing import style
from repro.drawing.panels import long_table
from repro.exhibits import catalogue, declare
from repro.exhibits.many_arms import RANKS
from repro.exhibits.print_compatible import guesses
from repro.exhibits.schematics import words
from repro.experiments.stored_networks import architecture
from repro.model.parameters import NAMES
from repro_studies import analysis
from repro_studies.factorial import effects
from repro_studies.interpretations import VARIANTS, ablation_figure

REFERENCE = Path(__file__).resolve().parents[2] / "docs" / "reference" / "tables"
#: Methods with a network of our training, of the paper's, and of the paper's ranges, too.
RECIPES = ("algorithm1", "algorithm1+paper-recipe", "algorithm1+paper-recipe-ranges")
CASES = ("N1", "N2", "N3", "N4")

EXHIBITS = {(each.kind, each.name): each for each in catalogue.EXHIBITS}
#: Drawings and layouts by the name of the exhibit.
FIGURES = {e.name: e.draw for e in catalogue.EXHIBITS if e.kind == "figure"}
LAYOUTS = {e.name: e.draw for e in catalogue.EXHIBITS if e.kind == "table"}


def series_of(panels: dict[str, tuple[str, ...]]) -> Iterator[tuple[int, tuple[str, str]]]:
    return enumerate((panel, name) for panel, series in panels.items() for name in series)


def waves(panels: dict[str, tuple[str, ...]], n: int = 60) -> pd.DataFrame:
    t = np.linspace(0.0, 9.4, n)
    return long_table((*names, t, np.sin(t + 0.3 * i) * (1 + i)) for i, names in series_of(panels))


def bands(panels: dict[str, tuple[str, ...]]) -> pd.DataFrame:
    k = np.arange(200.0)
    return long_table((*names, k / 18.85, 30.0 * np.cos(k + i) * np.exp(-k / 8)) for i, names in series_of(panels))


def subsampling_frame() -> pd.DataFrame:
    t = np.arange(64.0)
    parts = {("signal", "x"): t / 10, ("spectrum", "kept"): t[:16], ("spectrum", "dropped"): t[16:]}
    parts[("subsampled", "xs")] = t[:16] * 0.4
    return long_table((*names, x, np.cos(x)) for names, x in parts.items())


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


def candidates_frame() -> pd.DataFrame:
    both = itertools.product((("time", 1), ("frequency", 17)), range(20))
    rows = [(factor, f"{factor} candidate {i}", 0.3 + 0.1 * i, i == chosen) for (factor, chosen), i in both]
    return pd.DataFrame(rows, columns=["factor", "candidate", "rms_log_error", "chosen"])


RIVALS = ("algorithm1", "algorithm1+refinement", "least-squares", "true")
MOTIONS = ("T1", "T2", "T3", "T4")
BOTH = ("joint1", "joint2")
TRACKED = {"position": ("desired1", "desired2", *BOTH), "velocity": BOTH, "acceleration": BOTH}
WITHOUT_AXES = {"fig01", "fig02", "fig03", "fig04", "fig07", "fig18"}
#: Figures that must say so.
SIMULATED = {f"fig{number}" for number in range(18, 25)}
SIMULATED |= {"spread", "why", "coverage", "factorial", "ablation", "study", "study_calibration", "guesses"}
#: Tables that go on over pages.
LONG = ("audit",)


def setup_frame() -> pd.DataFrame:
    parts = ("pc", "serial", "write-ram", "ram", "pd", "pwm", "decoder", "uplink", "motors", "arm")
    rows = [(part, "-", "8192 x 2", "float32") for part in parts]
    rows += [("motors", "joint 1", "2.7192/1023", "N m"), ("pc", "-", "repro record", "-")]
    return pd.DataFrame(rows, columns=["component", "label", "value", "unit"])


def paths_frame() -> pd.DataFrame:
    t, sizes = np.linspace(0.0, 6.0, 50), {"desired": 0.0315, "actual": 0.031}
    both = itertools.product(MOTIONS, sizes.items())
    return long_table((case, name, size * np.cos(t), size * np.sin(t) - 0.2) for case, (name, size) in both)


def why_figure_frame() -> pd.DataFrame:
    """Two responses of three seeds in the four cells."""
    cells = itertools.product(("id", "validation"), ("ideal", "tracked"), ("measured", "desired"), (1, 2, 4))
    frame = pd.DataFrame(cells, columns=["response", "training", "image_motion", "seed"])
    causes = 0.1 * (frame["training"] == "tracked") + 0.05 * (frame["image_motion"] == "desired")
    return frame.assign(value=0.7 + causes + 0.01 * frame["seed"])


def ranks_frame() -> pd.DataFrame:
    both = itertools.product(("Eq. 1", "unmodelled", "other generator"), NAMES, np.linspace(0.0, 1.0, 11))
    rows = [(arms, name, level, 300, 280, level**2, level) for arms, name, level in both]
    return pd.DataFrame(rows, columns=list(RANKS))


def spread_frame() -> pd.DataFrame:
    runs = itertools.product(("ID", *MOTIONS), (1, 2), RIVALS, (1, 2, 5, 7, 11))
    rows = [(*run, 0.9 + 0.01 * (i % 7)) for i, run in enumerate(runs)]
    frame = pd.DataFrame(rows, columns=["case", "joint", "method", "experiment", "total"])
    groups = frame.groupby(["case", "joint", "method"])
    return frame.assign(median=groups["total"].transform("median"))


def guesses_frame() -> pd.DataFrame:
    """Four experiments by the number of guesses."""
    with TemporaryDirectory() as folder:
        guess_scores().to_csv(path := Path(folder) / "scores.csv", index=False)
        return guesses.numbers({"scores": [path]}, {})


def readings_frame() -> pd.DataFrame:
    """Numbers of each reading: one far below the others on the numeric arms, another one on the simulated arm."""
    rows = []
    for i, reading in enumerate(VARIANTS.values()):
        numeric = (0.3012, 0.1, 0.2847) if reading.name == "rad/s" else (0.975, 0.9312, 0.968)
        arm = (0.9512, 0.4811, 0.9667) if reading.name == "SI units" else (0.953, 0.9411, 0.9667)
        arm = (0.9612, 0.9222, *arm)
        shares = [share + 0.0007 * (i % 5) for share in (*numeric, *arm)]
        rows.append((reading.question, reading.name, 40_000 + i, 1.25e-4 * (1 + i), *shares))
    of_arm = ["arm_id", "arm_validation", "arm_refined", "arm_least_squares", "arm_true"]
    shares = ["id_mean", "id_lowest", "validation_mean", *of_arm]
    return pd.DataFrame(rows, columns=["question", "reading", "steps", "held_out_loss", *shares])


MOTION = dict.fromkeys(("position", "velocity", "acceleration"), BOTH)
NUMERIC = {case: {f"{case}/joint{joint}": ("actual", "rebuilt") for joint in (1, 2)} for case in CASES}
ALL_NUMERIC = NUMERIC["N1"] | NUMERIC["N2"] | NUMERIC["N3"] | NUMERIC["N4"]
TORQUES = dict.fromkeys(("torque1", "torque2"), ("measured", *RIVALS))
VALIDATED = {f"{case} {panel}": series for case in MOTIONS for panel, series in TORQUES.items()}

FRAMES: dict[str, Callable[[], pd.DataFrame]] = {
    **{name: partial(words, name) for name in ("fig01", "fig02", "fig03", "fig04")},
    "fig05": subsampling_frame,
    "fig06": lambda: waves(MOTION),
    "fig07": lambda: architecture(NetworkSettings()),
    "fig08": examples_frame,
    "fig09": lambda: waves(dict.fromkeys(BOTH, ("p05", "p25", "p50", "p75", "p95", "mean"))),
    "fig10": lambda: waves({"loss": ("train", "test")}).assign(y=lambda f: np.exp(-f["x"])),
    "fig11": kernels_frame,
    "fig12": lambda: waves(NUMERIC["N1"] | NUMERIC["N2"]),
    "fig13": lambda: waves(NUMERIC["N3"] | NUMERIC["N4"]),
    "fig14": lambda: bands(ALL_NUMERIC),
    "fig15": lambda: waves(ALL_NUMERIC, 600),
    "fig16": lambda: waves(MOTION, 600),
    "fig17": lambda: bands(ALL_NUMERIC).assign(y=lambda f: np.sin(7 * f["x"])),
    "fig18": setup_frame,
    "fig19": lambda: waves(TORQUES | TRACKED),
    "fig20": lambda: bands(TORQUES),
    "fig21": paths_frame,
    "fig22": lambda: waves({f"{case} {panel}": names for case in MOTIONS for panel, names in TRACKED.items()}),
    "fig23": lambda: waves(VALIDATED),
    "fig24": lambda: bands(VALIDATED),
    "spread": spread_frame,
    "why": why_figure_frame,
    "coverage": ranks_frame,
    "paper_recipe": lambda: long_table(
        ("loss", name, [1e3, 1e4, 1e5], [0.01, 0.003, last])
        for name, last in zip(RECIPES, (3e-4, 9e-4, 6e-4), strict=True)
    ),
    "metric_search": candidates_frame,
    "factorial": lambda: effects(factorial_scores()),
    "guesses": guesses_frame,
    "ablation": lambda: ablation_figure(readings_frame()),
    "study": lambda: analysis.maps(outcomes({"wide": -0.07, "narrow": 0.03})),
    "study_calibration": lambda: analysis.calibration(outcomes({"wide": -0.07, "narrow": 0.03})),
}


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
