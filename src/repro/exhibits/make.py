"""Makes exhibits: their numbers, then their layouts or drawings from them."""

from collections.abc import Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import cast

from matplotlib.figure import Figure

from repro.errors import InputError
from repro.exhibits import style
from repro.exhibits.declare import Exhibit, Inputs
from repro.exhibits.markup import Table
from repro.files import read_csv, write_csv, write_text
from repro.pipeline.job import Config


def declared(definition: str) -> Exhibit:
    """Exhibit by where it is declared, so that a job imports only the module of its own exhibits."""
    module, _, name = definition.partition(":")
    exhibit: Exhibit = getattr(import_module(module), name)
    return exhibit


def make_exhibits(
    exhibits: Sequence[str], inputs: Inputs, outputs: Mapping[str, Sequence[Path]], config: Config
) -> None:
    """Write exhibits of the same inputs, each to outputs named after its target and kind."""
    for exhibit in map(declared, exhibits):
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


def laid_out(exhibit: Exhibit, csv_path: Path) -> Table:
    """A table laid out from its CSV."""
    frame = read_csv(csv_path)
    try:
        return cast("Table", exhibit.draw(frame))
    except InputError as error:
        raise InputError(f"{csv_path}: {error}") from error
    except KeyError as error:  # of another version
        raise InputError.at(str(csv_path), f"no {error}", "the columns and names that this version writes") from error


def lay_out(exhibit: Exhibit, csv_path: Path, tex_path: Path, md_path: Path) -> None:
    """Write a table from its CSV as a LaTeX table environment and as Markdown."""
    table = laid_out(exhibit, csv_path)
    write_text(tex_path, table.tex(f"tab:{exhibit.name}"))
    write_text(md_path, table.md(exhibit.label))


def draw(exhibit: Exhibit, csv_path: Path, pdf_path: Path, png_path: Path) -> None:
    """Draw a figure from its CSV; the same CSV gives the same bytes."""
    frame = read_csv(csv_path)
    with style.house_style():
        try:
            figure = cast("Figure", exhibit.draw(frame))
        except InputError as error:
            raise InputError(f"{csv_path}: {error}") from error
        style.save(figure, exhibit.name, pdf_path, png_path)
