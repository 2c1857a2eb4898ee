"""The report of a run as one HTML text: every result, with what computed it."""

import hashlib
import os
import platform
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pandas as pd
from markupsafe import Markup

from repro.config.model import Configuration
from repro.drawing.embed import Picture, environment, link, picture, policy, read_bytes
from repro.drawing.markup import SUPERSCRIPTS, TIMES, Table, Text, plain, unit
from repro.drawing.style import MEANINGS, title_of
from repro.errors import InputError
from repro.exhibits import declare
from repro.exhibits.catalogue import FIGURES, TABLES, TARGETS
from repro.exhibits.declare import Exhibit, read_shown
from repro.exhibits.result_tables import similarities
from repro.files import read_rows, write_text
from repro.paper.claims import (
    ASSERTIONS,
    DIFFERS,
    EVIDENCE,
    EXTENSION,
    LIMITS,
    NOT_RUN,
    VERDICTS,
    Basis,
    broken,
    by_basis,
    causes,
)
from repro.paper.published import PublishedValue, load_published, similarity_cells
from repro.provenance import commit, package_versions
from repro.report.headline import (
    answer,
    headline_table,
    longer_searches,
    lowest_cells,
    shares,
    trained_as_printed,
)

#: Shown with the headline: Algorithm 1 as listed next to least squares, over the number of guesses.
HEADLINE_FIGURE = "guesses"
#: The report must stay below this, so that it can be mailed and opened anywhere.
LARGEST_REPORT = 15_000_000


@dataclass(frozen=True)
class ReportInputs:
    """Files and facts that one report shows."""

    results: Path  # folder with ``claims.csv``, ``tables/`` and ``figures/`` (the numbers drawn)
    figures: Path  # folder with ``figNN.png`` and ``figNN.pdf``
    captures: Sequence[Path]  # files of the stored captures, if the results are from such
    config_sha256: str  # SHA-256 of the configuration, in hexadecimal
    provenance: Mapping[str, str]  # commit, packages and the like; empty if nobody recorded them
    notice: str = ""  # a warning for the top of the page, for example that the budgets were tiny
    guesses: int = 0  # of Algorithm 1 in the comparison over the accepted experiments
    docs: Path | None = None  # pages that the report links to, with results of an earlier run in ``reference/``

    @property
    def page(self) -> Path:
        """Where the report goes; links to files beside it start there."""
        return self.results / "report" / "index.html"

    @property
    def shown_results(self) -> str:
        """Results folder as a command names it, wherever the checkout lies."""
        return self.results.name if self.results.is_absolute() else self.results.as_posix()

    def link_to(self, page: str) -> str:
        """Way from the report to a page of docs/ and its anchor; empty if the pages are not there."""
        return "" if self.docs is None else Path(os.path.relpath(self.docs / page, self.page.parent)).as_posix()

    def kept(self, exhibit: Exhibit) -> Path | None:
        """Numbers of an exhibit that is made on request, as an earlier run left them."""
        path = _kept(exhibit, self.docs)
        return path if exhibit.optional and path and path.exists() else None


def pages_of(checkout: Path) -> Path | None:
    """Folder docs/ of the checkout whose templates these are, if it is one."""
    docs = checkout.resolve().parents[2] / "docs"
    return docs if docs.is_dir() else None


def _kept(exhibit: Exhibit, docs: Path | None) -> Path | None:
    return docs and docs / "reference" / f"{exhibit.kind}s" / f"{exhibit.name}.csv"


def _files(exhibit: Exhibit, results: Path, figures: Path) -> list[Path]:
    """Numbers of an exhibit, its table or figure to print, and the picture of a figure."""
    numbers = results / f"{exhibit.kind}s" / f"{exhibit.name}.csv"
    if exhibit.kind == "table":
        return [numbers, numbers.with_suffix(".tex")]
    return [numbers, *(figures / f"{exhibit.name}.{ext}" for ext in ("pdf", "png"))]


def made_on_request(results: Path, figures: Path, docs: Path | None = None) -> str:
    """Digest of the optional results that exist: the report shows them, although its rule does not require them."""
    optional = [one for one in (*TABLES, *FIGURES) if one.optional]
    files = [path for one in optional for path in (*_files(one, results, figures), _kept(one, docs))]
    content = b"".join(path.name.encode() + path.read_bytes() for path in files if path and path.is_file())
    return f"results made on request {hashlib.sha256(content).hexdigest()[:12]}"


def show(exhibit: Exhibit, inputs: ReportInputs) -> dict[str, object]:
    """Lay out a table or embed a figure, and link its data; reading refuses a missing file unless it is optional.

    What is made on request and not of this run is shown as an earlier run left it.
    """
    needed = _files(exhibit, inputs.results, inputs.figures)
    present = [path for path in needed if path.exists() or not exhibit.optional]
    missing = len(present) < len(needed)
    kept = inputs.kept(exhibit) if missing else None
    if missing:
        present = [kept] if kept else []
    shown: dict[str, object] = {"table": None, "picture": None}
    if present and exhibit.kind == "table":
        shown["table"] = _with_published(exhibit, present[0])
    elif kept:
        shown["picture"] = _drawn(exhibit, kept)
    elif present:
        shown["picture"] = picture(needed[-1])
    links = [link(path, inputs.page) for path in present[:2]]
    return {"exhibit": exhibit, "links": links, "missing": missing, "kept": kept is not None, **shown}


def _on_request(name: str, inputs: ReportInputs, read: Callable[[Path], object]) -> dict[str, object]:
    """What is read from a table that is made on request, of this run or of a kept one; nothing where it is missing."""
    (exhibit,) = (one for one in TABLES if one.name == name)
    own = _files(exhibit, inputs.results, inputs.figures)[0]
    path = own if own.exists() else inputs.kept(exhibit)
    return {} if path is None else {"target": exhibit.target, "kept": path != own, "found": read(path)}


def _drawn(exhibit: Exhibit, numbers: Path) -> Picture:
    """A figure drawn from its numbers."""
    with TemporaryDirectory() as folder:
        pdf, png = (Path(folder, f"{exhibit.name}.{ending}") for ending in ("pdf", "png"))
        declare.show(exhibit, {"csv": numbers, "pdf": pdf, "png": png})
        return picture(png)


def _with_published(exhibit: Exhibit, numbers: Path) -> Table:
    """A table laid out from its numbers, after what the paper prints of it."""
    table = read_shown(exhibit, numbers)
    if not isinstance(table, Table):
        raise TypeError(exhibit.definition)
    return replace(table, blocks=[*_published(exhibit), *table.blocks])


def _published(exhibit: Exhibit) -> list[tuple[Text, Sequence[Sequence[Text]]]]:
    """The paper's own blocks of a table of similarities: those of Tables 7 and 10; the cells of Table 6 are lost."""
    numbers = load_published()
    if exhibit.target == "table06":
        total = numbers["abstract/numeric/total"]
        return [(plain(f"Published, Algorithm 1: cells lost; the abstract says {total.relation} {total} %"), [])]
    cells = similarity_cells(numbers).query("place == @exhibit.label")
    if cells.empty:
        return []
    factors = ["time", "frequency", "total"]
    printed = similarities(
        cells.assign(total_sd=0.0, seeds=1, **cells[factors] / 100.0), list(dict.fromkeys(cells["case"])), ""
    )
    return [(plain("Published, ") + (heading or ""), rows) for heading, rows in printed.blocks]


COLUMNS = (
    "id", "place", "quantity", "unit", "basis", "published", "ours", "difference", "tolerance", "verdict", "asserted",
    "cause", "target", "note",
)  # fmt: skip
_ID = re.compile(r"[\w./+:,()@-]+")
_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")
_NO_UNIT = ("", "1", "-", "not printed")
_MINUS = "\N{MINUS SIGN}"
#: What begins a negative number within a text.
_HYPHEN = re.compile(r"(?<!\w)-(?=\d)")


@dataclass(frozen=True)
class Cell:
    """A cell of the ledger: what it shows, and what it is sorted by (empty if by what it shows)."""

    text: str
    value: str = ""


def read_claims(path: Path) -> list[dict[str, Any]]:
    """Rows of ``claims.csv`` with their numbers as cells, and whether each is of an extension and as asserted.

    Published numbers and ours have their unit; a difference and a tolerance have that of what is published.
    """
    rows = read_rows(path, COLUMNS)
    bases = tuple(str(basis) for basis in Basis)
    allowed = {"basis": bases, "asserted": ("", *ASSERTIONS), "cause": ("", *causes())}
    seen: set[str] = set()
    for number, row in enumerate(rows, start=1):
        place = f"{path}: row {number}"
        for name in ("place", "quantity"):
            if not row[name].strip():
                raise InputError.at(f"{place}: {name}", "nothing", "text")
        if not _ID.fullmatch(row["id"]) or row["id"] in seen:
            raise InputError.at(f"{place}: id", repr(row["id"]), "an id without blanks, used once")
        if row["verdict"] not in VERDICTS:
            raise InputError.at(f"{place}: verdict", repr(row["verdict"]), f"one of {', '.join(VERDICTS)}")
        for name, values in allowed.items():
            if row[name] not in values:
                raise InputError.at(f"{place}: {name}", repr(row[name]), f"one of {', '.join(map(repr, values))}")
        seen.add(row["id"])
    published = {number.id: number for number in load_published()}
    lost = set(broken(pd.DataFrame(rows, columns=list(COLUMNS)))["id"])
    return [
        {
            **row,
            **_cells(row, published[number].relation if number in published else ""),
            "label": _label(published[number], extension) if number in published else row["quantity"],
            "extension": extension,
            "shown_basis": "extension" if extension else row["basis"],
            "satisfied": row["id"] not in lost,
        }
        for row in rows
        for number, _, extension in [row["id"].partition(EXTENSION)]
    ]


def _label(number: PublishedValue, extension: str) -> str:
    """What a published number is of, or the extension that is compared with it: quantity, case, joint and method."""
    method = f"{number.method}+{extension}" if extension else number.method
    parts = [number.parameter or number.quantity, f"of {number.case}" if number.case else ""]
    parts += [f"joint {number.joint}" if number.joint else "", title_of(method)]
    return ", ".join(part for part in (" ".join(filter(None, parts[:2])), *parts[2:]) if part)


def _cells(row: Mapping[str, str], relation: str) -> dict[str, Cell]:
    si, published = row["unit"].strip(), row["published"].strip()
    if row["verdict"] == NOT_RUN:  # what the default run has instead is not comparable
        row = {**row, "difference": "", "tolerance": "", "ours": row["ours"] if row["basis"] == Basis.SETTING else ""}
    shown = "" if si in _NO_UNIT else f"\N{NO-BREAK SPACE}{unit(si).md}"
    whole, _, part = published.partition(".")
    # One more than published, and at least two; None if the number is not a plain decimal.
    decimals = max(len(part), 1) + 1 if _NUMBER.fullmatch(published) and (whole + part).lstrip("+-").isdigit() else None
    return {
        "published": _cell(published, None, shown, before=f"{relation} " if relation in LIMITS else ""),
        "ours": _cell(row["ours"], decimals, shown),
        "difference": _cell(row["difference"], decimals, signed=True),
        "tolerance": _cell(row["tolerance"], decimals),
    }


def _cell(text: str, decimals: int | None, unit: str = "", signed: bool = False, before: str = "") -> Cell:
    """A number as it is written, or with `decimals` where it has more; text as it is."""
    text = text.strip()
    if not _NUMBER.fullmatch(text):
        return Cell("" if text.lower() in ("nan", "") else text)
    value, shown = float(text), text
    written = len(text.partition(".")[2])
    if decimals is not None and written > decimals and "e" not in text.lower():
        shown = f"{value:.{decimals}f}"
    if float(shown) == 0.0 != value or len(shown) > 10:
        shown = f"{value:.3g}"
    if signed and value > 0:
        shown = f"+{shown.lstrip('+')}"
    digits, e, power = shown.lower().partition("e")
    if e:
        shown = f"{digits}{TIMES}10{str(int(power)).translate(SUPERSCRIPTS)}"
    return Cell(before + shown.replace("-", _MINUS) + unit, repr(value))


_TEMPLATES = Path(__file__).parent


def _within_a_sentence(title: str) -> str:
    """A title as it stands within a sentence: only an article loses its capital."""
    first, _, rest = title.partition(" ")
    return f"{first.lower() if first in ('A', 'The', 'One', 'What') else first} {rest}"


def build_report(inputs: ReportInputs) -> str:
    """Lay out the report."""
    ledger_file, audit_file = inputs.results / "claims.csv", inputs.results / "tables" / "audit.csv"
    order = [*map(str, Basis), "extension"]  # results before settings
    claims = sorted(read_claims(ledger_file), key=lambda claim: order.index(claim["shown_basis"]))
    counts = by_basis(pd.DataFrame(claims, columns=list(COLUMNS)))
    style, script = (Markup((_TEMPLATES / name).read_text("utf-8")) for name in ("report.css", "report.js"))
    templates = environment(_TEMPLATES)
    templates.filters["slug"] = lambda text: "-".join(str(text).split())
    templates.filters["minus"] = partial(_HYPHEN.sub, _MINUS)
    templates.filters["lower_first"] = _within_a_sentence
    differing = [claim for claim in claims if claim["verdict"] == DIFFERS]
    tested = [str(basis) for basis in EVIDENCE]
    causes_by_name = causes()
    of_causes = {name: [claim for claim in differing if claim["cause"] == name] for name in causes_by_name}
    figures = [show(exhibit, inputs) for exhibit in FIGURES]
    text = templates.get_template("report.html").render(
        inputs=inputs,
        style=style,
        script=script,
        policy=policy(style, script),
        claims=claims,
        claims_link=link(ledger_file, inputs.page),
        counts=counts[counts.any(axis=1)],
        meanings=VERDICTS,
        methods=[(title_of(name), meaning) for name, meaning in MEANINGS.items()],
        tested=counts[tested].sum(axis=1),
        asserted=[claim for claim in claims if claim["asserted"]],
        headline=headline_table(inputs.results),
        shares=shares(inputs.results),
        headline_figure=figures[[one.name for one in FIGURES].index(HEADLINE_FIGURE)],
        answer=answer(inputs.results, inputs.guesses),
        more_guesses=_on_request("accepted", inputs, longer_searches),
        as_printed=_on_request("paper_recipe", inputs, trained_as_printed),
        lowest_cells=lowest_cells(inputs.results),
        differing=[(causes_by_name[name], own) for name, own in of_causes.items() if own],
        differing_of_tested=[
            (causes_by_name[name], len(found))
            for name, own in of_causes.items()
            if (found := [claim for claim in own if claim["shown_basis"] in tested])
        ],
        audit=[{name: cell for name, cell in row.items() if name != "id"} for row in read_rows(audit_file)],
        audit_links=[link(path, inputs.page) for path in (audit_file, audit_file.with_suffix(".tex")) if path.exists()],
        tables=[show(exhibit, inputs) for exhibit in TABLES],
        figures=figures,
        targets=TARGETS,
        captures=[
            (path.name, hashlib.sha256(read_bytes(path, "a stored capture")).hexdigest()) for path in inputs.captures
        ],
    )
    size = len(text.encode())
    if size > LARGEST_REPORT:
        expected = f"{LARGEST_REPORT / 1e6:g} MB at most; the figures are what fills it"
        raise InputError.at(str(inputs.page), f"{size / 1e6:.1f} MB", expected)
    return text


def make_report(
    checkout: str, overlays: Sequence[str], digest: str, config: Configuration, captures: Sequence[Path] = ()
) -> None:
    """Write ``report/index.html`` in the results folder."""
    stored = "networks that come with the project, not trained in this run"
    is_stored = config.training.source == "stored"
    # No times: the same commit, configuration and results give the same page.
    provenance = {
        "commit": commit(Path(checkout)),
        "networks": stored if is_stored else "trained in this run",
        **{f"packages.{name}": version for name, version in package_versions().items()},
        "python": platform.python_version(),
    }
    names = ", ".join(Path(name).name for name in overlays)
    notice = f"Made with the settings of {names}, not those of the full reproduction." if overlays else ""
    if is_stored:
        notice = f"{notice} {stored.capitalize()}.".strip()
    folders = (Path(config.results), Path(config.figures))
    guesses = config.spread.inner_limit * config.algorithm1.executions
    inputs = ReportInputs(*folders, sorted(captures), digest, provenance, notice, guesses, pages_of(Path(checkout)))
    write_text(inputs.page, build_report(inputs))
