"""Declaration of a table or figure: a decorated function makes its rule, target, report section and test."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Literal

import pandas as pd
from matplotlib.figure import Figure

from repro.exhibits.markup import Table
from repro.pipeline.job import Config

#: Files by the name of the input.
Inputs = Mapping[str, Sequence[Path]]

Kind = Literal["table", "figure"]
Numbers = Callable[[Inputs, Config], pd.DataFrame]
Layout = Callable[[pd.DataFrame], Table]
Drawing = Callable[[pd.DataFrame], Figure]
#: Which floats depend on a network: none, those of a claim about it unless it is of least squares, or all.
Trained = Literal["no", "claims", "all"]

METHOD, SIGNALS, DATA, MODEL, METRIC = "Method", "Signals", "Data", "Model", "Metric"
NUMERIC, VALIDATION, ABLATION = "Numeric results", "Numeric validation", "Ablation"
EXPERIMENT, CLAIMS = "Experiment (simulated)", "Claims"

#: Sections of the configuration that exhibits of the simulated arm depend on.
ARM = ("signals", "arm", "board", "experiment")


@dataclass(frozen=True)
class Exhibit:
    """One table or figure: how its numbers are computed from files and settings, and how they are shown."""

    kind: Kind
    number: int  # in the paper; 0 for an addition of ours
    name: str  # stem of its files
    target: str  # target of the workflow that makes it, also its anchor in the report
    label: str  # what the paper calls it; an addition of ours has a label of its own
    title: str  # what it shows, in a few words
    category: str  # chapter of the workflow's own report
    caption: str
    numbers: Numbers
    draw: Layout | Drawing
    inputs: tuple[str, ...]  # what its numbers are computed from: keys of SOURCES in `workflow/rules/exhibits.smk`
    sections: tuple[str, ...]  # sections of the configuration that its numbers depend on
    trained: Trained
    optional: bool  # whether it is made only on request: a report is complete without it

    @property
    def simulated(self) -> bool:
        """Whether its numbers come from the simulated arm."""
        return self.category in (EXPERIMENT, ABLATION)

    @property
    def definition(self) -> str:
        """Where it is declared, ``package.module:name``."""
        return f"{self.numbers.__module__}:{self.numbers.__name__}"


def _declare(
    kind: Kind,
    which: int | str,
    title: str,
    category: str,
    draw: Layout | Drawing,
    *,
    inputs: tuple[str, ...] = (),
    sections: tuple[str, ...] = (),
    trained: Trained = "no",
    optional: bool = False,
    label: str = "",
    target: str = "",
) -> Callable[[Numbers], Exhibit]:
    """Declare the decorated function as the numbers of an exhibit, and its docstring as the caption.

    An exhibit of the paper is named by its number, an addition of ours by its own name.
    """
    number = which if isinstance(which, int) else 0
    if isinstance(which, int):
        name = target = f"table{which:02d}" if kind == "table" else f"fig{which:02d}"
        label = f"{kind.capitalize()} {which}"
    else:
        name, target = which, target or f"{which}_{kind}"
        label = label or name.replace("_", " ").capitalize()

    def declared(numbers: Numbers) -> Exhibit:
        caption = " ".join((numbers.__doc__ or "").split())
        shown = (number, name, target, label, title, category, caption)
        return Exhibit(kind, *shown, numbers, draw, inputs, sections, trained, optional)

    return declared


table, figure = partial(_declare, "table"), partial(_declare, "figure")
