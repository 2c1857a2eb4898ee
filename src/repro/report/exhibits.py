"""Tables and figures of the page, each with its caption, its data and the command that remakes it."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from repro.exhibits.declare import Exhibit
from repro.exhibits.make import laid_out
from repro.exhibits.markup import Table
from repro.files import read_rows
from repro.report.embed import Link, Picture, link, pictures
from repro.report.inputs import ReportInputs


@dataclass(frozen=True)
class Shown:
    """An exhibit with what the page shows of it."""

    exhibit: Exhibit  # what it is
    links: list[Link]  # its data
    missing: list[str]  # names of its files that are not there
    table: Table | None = None  # of a table that is there
    picture: Picture | None = None  # of a figure that is there


def show_tables(exhibits: Sequence[Exhibit], inputs: ReportInputs) -> list[Shown]:
    """Lay out every table from its CSV and link it and its LaTeX."""
    return [_show_table(exhibit, inputs) for exhibit in exhibits]


def _show_table(exhibit: Exhibit, inputs: ReportInputs) -> Shown:
    data = [inputs.results / "tables" / f"{exhibit.name}{suffix}" for suffix in (".csv", ".tex")]
    found, missing = _present(data, inputs.partial or exhibit.optional)
    links = [link(path, inputs.page) for path in found]
    table = laid_out(exhibit, data[0]) if data[0] in found else None
    return Shown(exhibit, links, missing, table=table)


def show_figures(exhibits: Sequence[Exhibit], inputs: ReportInputs) -> list[Shown]:
    """Embed every figure and link the numbers drawn and the vector file."""
    images = {exhibit.name: inputs.figures / f"{exhibit.name}.png" for exhibit in exhibits}
    may_miss = {exhibit.name: inputs.partial or exhibit.optional for exhibit in exhibits}
    embedded = pictures({name: path for name, path in images.items() if path.exists() or not may_miss[name]})
    shown = []
    for exhibit in exhibits:
        data = [inputs.results / "figures" / f"{exhibit.name}.csv", inputs.figures / f"{exhibit.name}.pdf"]
        found, missing = _present([images[exhibit.name], *data], may_miss[exhibit.name])
        links = [link(path, inputs.page) for path in data if path in found]
        picture = embedded.get(exhibit.name)
        shown.append(Shown(exhibit, links, missing, picture=picture))
    return shown


def _present(paths: Sequence[Path], may_miss: bool) -> tuple[list[Path], list[str]]:
    """Paths to read, and names of files that are not there; where none may miss, all are read and the reading tells."""
    if not may_miss:
        return list(paths), []
    return [path for path in paths if path.exists()], [path.name for path in paths if not path.exists()]


@dataclass(frozen=True)
class Audit:
    """The audit of the paper: a table of any columns, and its data."""

    header: list[str]
    rows: list[list[str]]
    links: list[Link]


def show_audit(inputs: ReportInputs) -> Audit | None:
    """Read the audit."""
    path = inputs.results / "tables" / "audit.csv"
    if inputs.partial and not path.exists():
        return None
    rows = read_rows(path, ("id",))
    columns = [name for name in rows[0] if name != "id"] if rows else []
    links = [link(file, inputs.page) for file in (path, path.with_suffix(".tex")) if file.exists()]
    return Audit([name.replace("_", " ") for name in columns], [[row[name] for name in columns] for row in rows], links)
