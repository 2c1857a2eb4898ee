"""The one look of every figure: sizes, type, colours, strokes, and saving to the same bytes every time."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, TypeVar

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure, FigureBase
from matplotlib.ticker import MaxNLocator

from repro.drawing import markup
from repro.files import atomic_write

F = TypeVar("F", bound=FigureBase)

#: Widths of one IEEE column and of the full page, inches.
COLUMN: Final = 3.5
PAGE: Final = markup.PAGE

#: Points: running text of a figure, and the smallest type (ticks, notes).
TEXT_SIZE: Final = 8.0
SMALL_SIZE: Final = 7.0

PNG_DPI: Final = 300

_TICKS = {"labelsize": SMALL_SIZE, "major.width": 0.6, "minor.width": 0.4, "major.size": 2.5, "minor.size": 1.5}
#: Where it differs from matplotlib's own. Fonts are the ones matplotlib ships: every machine draws the same glyphs.
RC: Final[dict[Any, Any]] = {
    "font.family": "STIXGeneral",
    "mathtext.fontset": "stix",
    "font.size": TEXT_SIZE,
    "axes.titlesize": TEXT_SIZE,
    "axes.titlelocation": "left",
    "axes.titlepad": 3.0,
    "axes.labelpad": 2.0,
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.xmargin": 0.01,
    "axes.axisbelow": True,
    "axes.grid": True,
    "grid.color": "0.90",
    "grid.linewidth": 0.4,
    **{f"{axis}tick.{name}": value for axis in "xy" for name, value in _TICKS.items()},
    "lines.solid_capstyle": "round",
    "legend.frameon": False,
    "legend.borderpad": 0.2,
    "legend.borderaxespad": 0.2,
    "legend.handlelength": 2.6,
    "legend.columnspacing": 1.6,
    "figure.constrained_layout.h_pad": 0.03,
    "figure.constrained_layout.w_pad": 0.03,
    "path.simplify_threshold": 0.15,  # of a point in a PDF: a fifth of the thinnest line
    "pdf.fonttype": 42,
    "pdf.compression": 9,
    "savefig.dpi": PNG_DPI,
}


@dataclass(frozen=True)
class Appearance:
    """How a method or another series appears."""

    label: str  # in legends
    color: str
    dashes: tuple[float, ...]  # none for a solid line
    width: float
    marker: str = ""  # empty for what is only drawn as a line
    size: float = 0.0  # of the marker
    hollow: bool = False  # whether the marker is an outline

    @property
    def stroke(self) -> dict[str, Any]:
        """Look of a curve, as Matplotlib names it."""
        return {"color": self.color, "linestyle": (0, self.dashes) if self.dashes else "-", "linewidth": self.width}

    @property
    def mark(self) -> dict[str, Any]:
        """Look of a point."""
        edge = 0.7 if self.hollow else {"x": 0.9, "+": 0.8}.get(self.marker, 0.0)
        fill = {"fillstyle": "none"} if self.hollow else {}
        return {"marker": self.marker, "markersize": self.size, "markeredgewidth": edge, **fill}


_DASH_DOT, _SHORT, _DASHED = (6.0, 1.2, 1.2, 1.2), (2.0, 1.2), (3.5, 2.5)

#: Appearance of each method of `repro.identification.method`, in the order of tables and legends.
METHODS: Final = {
    "algorithm1": Appearance("Algorithm 1", "#5ab8ea", _DASH_DOT, 1.1, "o", 3.4),
    "algorithm1/one-run": Appearance("Algorithm 1, one run", "#5ab8ea", _SHORT, 1.1, "d", 3.4),
    "least-squares": Appearance("Least squares", "#d1490a", _DASHED, 1.1, "x", 3.4),
    "bounded": Appearance("Nonnegative least squares", "#e7a03c", (8.0, 2.0), 1.1, "<", 3.4),
    "algorithm1+desired": Appearance("Algorithm 1, desired motion", "#3b7dbd", _SHORT, 1.0, "*", 4.2),
    "algorithm1+tracked-measured": Appearance("Algorithm 1, closed loop", "#c080c4", _SHORT, 1.0, "P", 3.6),
    "algorithm1+tracked": Appearance("Algorithm 1, both extensions", "#8a3a8f", _DASH_DOT, 1.1, "p", 3.6),
    "algorithm1+tracked/one-run": Appearance("Algorithm 1, both, one run", "#8a3a8f", _SHORT, 1.1, "8", 3.4),
    "algorithm1+refinement": Appearance("Algorithm 1 + refinement", "#004a78", (), 0.9, "D", 3.2, hollow=True),
    "algorithm1+local-search": Appearance("Refinement without network", "#a6761d", _SHORT, 1.0, "v", 3.4),
    "differential-evolution": Appearance("Differential evolution", "#44aa99", _DASHED, 1.0, "X", 3.4),
    "algorithm1+paper-recipe": Appearance("Algorithm 1, printed schedule", "#666666", _DASH_DOT, 1.1, "h", 3.4),
    "algorithm1+paper-recipe-ranges": Appearance(
        "Algorithm 1, trained as printed", "#999933", _DASH_DOT, 1.1, "H", 3.4
    ),
    "consistent": Appearance("Consistent least squares", "#7a2a00", (1.5, 1.0), 1.1, ">", 3.4),
    "true": Appearance("True parameters", "0.0", (1.0, 2.0), 1.1, "+", 4.0),
    "appendix": Appearance("True, without back-EMF", "0.45", (1.0, 2.0), 1.1, "1", 4.0),
}
#: What a name leaves unsaid, by method. Extensions are ours.
MEANINGS: Final = {
    "algorithm1/one-run": "all cells come from the run with the median score on ID",
    "algorithm1+desired": "line 18 computes f on the desired motion (extension)",
    "algorithm1+tracked-measured": "the network is trained on closed-loop motions (extension)",
    "algorithm1+tracked": "closed-loop training, and f on the desired motion in line 18 (extensions)",
    "algorithm1+tracked/one-run": "all cells come from one run (extensions)",
    "algorithm1+refinement": "differential evolution of candidates, which the network corrects at first (extension)",
    "algorithm1+local-search": "the refinement without the network, for comparison",
    "differential-evolution": "a direct search from uniform guesses, without a network",
    "algorithm1+paper-recipe": "trained by the paper's schedule",
    "algorithm1+paper-recipe-ranges": "trained by the paper's schedule on its ranges of parameters",
    "bounded": "no parameter is negative, as in line 22 of Algorithm 1",
    "consistent": "only physically possible parameters",
    "appendix": "the arm's parameters without what its motors add",
}


def title_of(method: str) -> str:
    """What tables and legends call a method."""
    return METHODS[method].label if method in METHODS else method


def key_to(methods: Iterable[str]) -> str:
    """Sentence that says what the names of these methods leave unsaid; empty if nothing."""
    known = [f"{title_of(name)}: {MEANINGS[name]}" for name in methods if name in MEANINGS]
    return f"{'; '.join(known)}." if known else ""


#: Every pair that meets in one panel also differs in lightness and in width or dash, so it reads in greyscale.
_SERIES = {
    "joint1": Appearance("Joint 1", "#00507f", (), 1.0),
    "joint2": Appearance("Joint 2", "#e08a00", (4.5, 1.5), 1.2),
    "actual": Appearance("Actual", "0.75", (), 2.2),
    "rebuilt": Appearance("Rebuilt by Algorithm 1", "#00507f", (3.5, 1.5), 0.8, "o", 2.2),
    "difference": Appearance("Difference", "#e08a00", (), 0.8),
    "train": Appearance("Training", "#79bde8", (), 1.2),
    "test": Appearance("Test", "#8c1d04", (3.5, 1.5), 1.0),
    "median": Appearance("Median", "#00304d", (), 1.2),
    "mean": Appearance("Mean", "#c44a00", (3.0, 1.5), 1.2),
    "desired": Appearance("Desired", "#00304d", (3.5, 1.5), 0.9),
    "desired1": Appearance("Desired, joint 1", "#9fcbe6", (), 2.6),
    "desired2": Appearance("Desired, joint 2", "#f8dcae", (), 2.6),
    "measured": Appearance("Measured", "0.80", (), 2.6),
    **METHODS,
}
#: How each series is drawn wherever it appears.
STROKES: Final = {name: entry.stroke for name, entry in _SERIES.items()}
#: Marks of the series that are also drawn point by point; the colour is that of the stroke.
MARKS: Final = {name: entry.mark for name, entry in _SERIES.items() if entry.marker}
#: What the legend calls each series.
SERIES_LABELS: Final = {name: entry.label for name, entry in _SERIES.items()}

#: Heads the legend of every figure whose signals come from the simulated arm.
SIMULATED: Final = "Simulated experiment"

#: Signs of sizes and ranges.
TIMES: Final = markup.TIMES
DASH: Final = "\N{EN DASH}"

#: Fills from light to dark, and the grey of whatever is set aside.
FILL_LIGHT: Final = "#cfe6f5"
FILL_DARK: Final = "#79b4da"
SET_ASIDE: Final = "0.62"
INK: Final = "0.15"
COLOUR_MAP: Final = "viridis"  # lightness rises all the way, so it survives greyscale


@contextmanager
def house_style() -> Iterator[None]:
    """Draw in the house style, whatever the user's own matplotlib settings are; they come back afterwards."""
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(RC)
        yield


def new_figure(width: float, height: float) -> Figure:
    """Make an empty figure with automatic spacing."""
    return Figure(figsize=(width, height), layout="constrained")


def new_panels(
    width: float, height: float, rows: int, columns: int, sharex: bool = False, sharey: bool = False
) -> tuple[Figure, Any]:
    """Make a figure and its panels in rows and columns."""
    figure = new_figure(width, height)
    return figure, figure.subplots(rows, columns, sharex=sharex, sharey=sharey)


def inches(width: float, height: float) -> tuple[Figure, Axes]:
    """Make a figure without axes lines, in which everything is placed in inches from its lower left corner."""
    figure = new_figure(width, height)
    figure.set_layout_engine("none")
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0), xlim=(0.0, width), ylim=(0.0, height))
    axes.set_axis_off()
    return figure, axes


def few_ticks(axes: Axes) -> None:
    """Put at most five round numbers on the y axis."""
    axes.yaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 2.5, 5, 10]))


def legend_above(figure: F, axes: Axes, columns: int, title: str | None = None) -> F:
    """Put the legend of `axes`, under its `title`, above all panels; return the figure."""
    figure.legend(*axes.get_legend_handles_labels(), loc="outside upper center", ncols=columns, title=title)
    return figure


def save(figure: Figure, title: str, pdf_path: Path, png_path: Path) -> None:
    """Write a figure as PDF and PNG without date and program version; settings of `house_style` are read here, too."""
    undated = {"Title": title, "Creator": None, "Producer": None, "CreationDate": None}
    atomic_write(pdf_path, lambda path: figure.savefig(path, format="pdf", metadata=undated))
    unversioned = {"Title": title, "Software": None}
    atomic_write(png_path, lambda path: figure.savefig(path, format="png", dpi=PNG_DPI, metadata=unversioned))
