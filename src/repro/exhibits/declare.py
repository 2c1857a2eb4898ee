"""Tables and figures: a decorated function declares rule, target, report section and test; how each is made."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Literal

import pandas as pd
from matplotlib.figure import Figure

from repro.config.model import Configuration
from repro.drawing import style
from repro.drawing.markup import Table
from repro.errors import InputError
from repro.files import read_csv, write_csv, write_text

#: Files by the name of the input.
Inputs = Mapping[str, Sequence[Path]]

Kind = Literal["table", "figure"]
Numbers = Callable[[Inputs, Configuration], pd.DataFrame]
Drawing = Callable[[pd.DataFrame], Table | Figure]
#: Which floats depend on a network: none, those of a claim about it unless it is of least squares, or all.
Trained = Literal["no", "claims", "all"]

#: Chapter of the workflow's own report.
Category = Literal[
    "Method", "Signals", "Data", "Model", "Metric", "Numeric results", "Numeric validation", "Ablation",
    "Experiment (simulated)", "Claims",
]  # fmt: skip

#: Sections of the configuration that exhibits of the simulated arm depend on.
ARM = ("signals", "arm", "board", "experiment")


@dataclass(frozen=True)
class Exhibit:
    """One table or figure: how its numbers are computed from files and settings, and how they are shown."""

    kind: Kind
    number: int  # in the paper; 0 for an addition of ours
    name: str  # stem of its files
    target: str  # name of its function, target of the workflow and anchor in the report
    label: str  # what the paper calls it; an addition of ours has a label of its own
    title: str  # what it shows, in a few words
    category: Category
    caption: str
    numbers: Numbers
    draw: Drawing
    inputs: tuple[str, ...]  # what its numbers are computed from: keys of SOURCES in `workflow/rules/exhibits.smk`
    sections: tuple[str, ...]  # sections of the configuration that its numbers depend on
    trained: Trained
    optional: bool  # whether it is made only on request: a report is complete without it

    @property
    def simulated(self) -> bool:
        """Whether its numbers come from the simulated arm."""
        return self.category in ("Experiment (simulated)", "Ablation")

    @property
    def definition(self) -> str:
        """Where it is declared, ``package.module:name``."""
        return f"{self.numbers.__module__}:{self.target}"


Declaration = Callable[[Numbers], Exhibit]


def _declare(
    kind: Kind,
    title: str,
    draw: Drawing,
    *,
    category: Category,
    inputs: tuple[str, ...] = (),
    sections: tuple[str, ...] = (),
    trained: Trained = "no",
    optional: bool = False,
    label: str = "",
) -> Declaration:
    """Declare a function as the numbers of an exhibit: its name is the target, its docstring the caption."""

    def declared(numbers: Numbers) -> Exhibit:
        target = numbers.__name__
        name = target.removesuffix(f"_{kind}")
        digits = name[-2:]  # of an exhibit of the paper
        number = int(digits) if digits.isdigit() else 0
        called = f"{kind.capitalize()} {number}" if number else label or name.replace("_", " ").capitalize()
        caption = " ".join((numbers.__doc__ or "").split())
        shown = (number, name, target, called, title, category, caption)
        return Exhibit(kind, *shown, numbers, draw, inputs, sections, trained, optional)

    return declared


table, figure = partial(_declare, "table"), partial(_declare, "figure")


def make_exhibits(
    exhibits: Sequence[str], inputs: Inputs, outputs: Mapping[str, Sequence[Path]], config: Configuration
) -> None:
    """Write exhibits of the same inputs, each to outputs named after its target and kind."""
    for definition in exhibits:
        module, _, name = definition.partition(":")  # so that a job imports only the module of its own exhibits
        exhibit: Exhibit = getattr(import_module(module), name)
        own = exhibit.target + "_"
        out = {name.removeprefix(own): files[0] for name, files in outputs.items() if name.startswith(own)}
        make_exhibit(exhibit, inputs, out, config)


def make_exhibit(exhibit: Exhibit, inputs: Inputs, out: Mapping[str, Path], config: Configuration) -> None:
    """Write an exhibit's tidy table, then its TeX and Markdown, or its PDF and PNG."""
    write_csv(out["csv"], exhibit.numbers(inputs, config))
    show(exhibit, out)


def show(exhibit: Exhibit, out: Mapping[str, Path]) -> None:
    """Write TeX and Markdown of a table, or PDF and PNG of a figure, from its CSV, with the same bytes each time."""
    with style.house_style():
        shown = read_shown(exhibit, out["csv"])
        if isinstance(shown, Table):
            write_text(out["tex"], shown.tex(f"tab:{exhibit.name}"))
            write_text(out["md"], shown.md(exhibit.label))
        else:
            style.save(shown, exhibit.name, out["pdf"], out["png"])


def read_shown(exhibit: Exhibit, csv_path: Path) -> Table | Figure:
    """A table laid out, or a figure drawn, from its CSV."""
    frame = read_csv(csv_path)
    try:
        return exhibit.draw(frame)
    except InputError as error:
        raise InputError.at(f"{csv_path}: {error.place}", error.found, error.expected) from error
    except KeyError as error:  # of another version
        raise InputError.at(str(csv_path), f"no {error}", "the columns and names that this version writes") from error
