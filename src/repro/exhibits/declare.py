"""Tables and figures: a decorated function declares rule, target, report section and test; how each is made."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Literal, cast

import pandas as pd
from matplotlib.figure import Figure

from repro.errors import InputError
from repro.exhibits import style
from repro.exhibits.markup import Table
from repro.files import read_csv, write_csv, write_text
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


Declaration = Callable[[Numbers], Exhibit]


def _declare(
    kind: Kind,
    which: int | str,
    title: str,
    draw: Layout | Drawing,
    *,
    category: str,
    inputs: tuple[str, ...] = (),
    sections: tuple[str, ...] = (),
    trained: Trained = "no",
    optional: bool = False,
    label: str = "",
    target: str = "",
) -> Declaration:
    """Declare the decorated function as the numbers of an exhibit, and its docstring as the caption."""
    if isinstance(which, int):  # an exhibit of the paper has a number, an addition of ours a name
        number, name, label = which, f"{kind.removesuffix('ure')}{which:02d}", f"{kind.capitalize()} {which}"
        target = name
    else:
        number, name, label = 0, which, label or which.replace("_", " ").capitalize()
        target = target or f"{which}_{kind}"

    def declared(numbers: Numbers) -> Exhibit:
        caption = " ".join((numbers.__doc__ or "").split())
        shown = (number, name, target, label, title, category, caption)
        return Exhibit(kind, *shown, numbers, draw, inputs, sections, trained, optional)

    return declared


table, figure = partial(_declare, "table"), partial(_declare, "figure")


def make_exhibits(
    exhibits: Sequence[str], inputs: Inputs, outputs: Mapping[str, Sequence[Path]], config: Config
) -> None:
    """Write exhibits of the same inputs, each to outputs named after its target and kind."""
    for definition in exhibits:
        module, _, name = definition.partition(":")  # so that a job imports only the module of its own exhibits
        exhibit: Exhibit = getattr(import_module(module), name)
        own = exhibit.target + "_"
        out = {name.removeprefix(own): files[0] for name, files in outputs.items() if name.startswith(own)}
        make_exhibit(exhibit, inputs, out, config)


def make_exhibit(exhibit: Exhibit, inputs: Inputs, out: Mapping[str, Path], config: Config) -> None:
    """Write an exhibit's tidy table, then its TeX and Markdown, or its PDF and PNG."""
    write_csv(out["csv"], exhibit.numbers(inputs, config))
    if exhibit.kind == "table":
        lay_out(exhibit, out["csv"], out["tex"], out["md"])
    else:
        draw(exhibit, out["csv"], out["pdf"], out["png"])


def shown(exhibit: Exhibit, csv_path: Path) -> Table | Figure:
    """A table laid out, or a figure drawn, from its CSV."""
    frame = read_csv(csv_path)
    try:
        return exhibit.draw(frame)
    except InputError as error:
        raise InputError(f"{csv_path}: {error}") from error
    except KeyError as error:  # of another version
        raise InputError.at(str(csv_path), f"no {error}", "the columns and names that this version writes") from error


def lay_out(exhibit: Exhibit, csv_path: Path, tex_path: Path, md_path: Path) -> None:
    """Write a table from its CSV as a LaTeX table environment and as Markdown."""
    table = cast("Table", shown(exhibit, csv_path))
    write_text(tex_path, table.tex(f"tab:{exhibit.name}"))
    write_text(md_path, table.md(exhibit.label))


def draw(exhibit: Exhibit, csv_path: Path, pdf_path: Path, png_path: Path) -> None:
    """Draw a figure from its CSV; the same CSV gives the same bytes."""
    with style.house_style():
        style.save(cast("Figure", shown(exhibit, csv_path)), exhibit.name, pdf_path, png_path)
