"""The report of a run as one HTML text: every result, with what computed it."""

import hashlib
import json
import platform
from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pandas as pd
from markupsafe import Markup

from repro.errors import InputError
from repro.exhibits.catalogue import FIGURES, TABLES, TARGETS
from repro.exhibits.declare import Exhibit
from repro.exhibits.make import laid_out
from repro.exhibits.markup import Table
from repro.exhibits.style import METHODS
from repro.files import read_csv, read_rows, write_text
from repro.paper.claims import Basis, summary
from repro.pipeline.job import Config
from repro.pipeline.monte_carlo import ALL, BETTER, COMPARISON_COLUMNS, OPEN, SAME, WORSE
from repro.pipeline.provenance import commit, package_versions
from repro.report.embed import Link, Picture, environment, link, pictures, policy, read_text
from repro.report.ledger import count, differences, read_claims, tally
from repro.signals.programs import SPAN

#: The report must stay below this, so that it can be mailed and opened anywhere.
LARGEST_REPORT = 15_000_000


@dataclass(frozen=True)
class ReportInputs:
    """Files and facts that one report shows."""

    results: Path  # folder with ``claims.csv``, ``tables/`` and ``figures/`` (the numbers drawn)
    figures: Path  # folder with ``figNN.png`` and ``figNN.pdf``
    captures: Path  # ``SHA256SUMS`` of the recorded runs
    config_sha256: str  # SHA-256 of the configuration, in hexadecimal
    command: str = "snakemake --cores 2"  # what a target's name is put after to remake it
    # commit, packages and the like, as JSON would hold them; empty if nobody recorded them
    provenance: Mapping[str, object] = field(default_factory=dict)
    notice: str = ""  # a warning for the top of the page, for example that the budgets were tiny

    @property
    def page(self) -> Path:
        """Where the report goes; links to files beside it start there."""
        return self.results / "report" / "index.html"


@dataclass(frozen=True)
class Shown:
    """An exhibit with what the page shows of it."""

    exhibit: Exhibit  # what it is
    links: list[Link]  # its data
    missing: list[str]  # names of its files that are not there
    table: Table | None = None  # of a table that is there
    picture: Picture | None = None  # of a figure that is there


def show_table(exhibit: Exhibit, inputs: ReportInputs) -> Shown:
    """Lay out a table from its CSV and link it and its LaTeX."""
    data = [inputs.results / "tables" / f"{exhibit.name}{suffix}" for suffix in (".csv", ".tex")]
    found, missing = _present(data, exhibit.optional)
    links = [link(path, inputs.page) for path in found]
    table = laid_out(exhibit, data[0]) if data[0] in found else None
    return Shown(exhibit, links, missing, table=table)


def show_figures(exhibits: Sequence[Exhibit], inputs: ReportInputs) -> list[Shown]:
    """Embed every figure and link the numbers drawn and the vector file."""
    images = {exhibit.name: inputs.figures / f"{exhibit.name}.png" for exhibit in exhibits}
    optional = {exhibit.name for exhibit in exhibits if exhibit.optional}
    embedded = pictures({name: path for name, path in images.items() if path.exists() or name not in optional})
    shown = []
    for exhibit in exhibits:
        data = [inputs.results / "figures" / f"{exhibit.name}.csv", inputs.figures / f"{exhibit.name}.pdf"]
        found, missing = _present([images[exhibit.name], *data], exhibit.optional)
        links = [link(path, inputs.page) for path in data if path in found]
        picture = embedded.get(exhibit.name)
        shown.append(Shown(exhibit, links, missing, picture=picture))
    return shown


def _present(paths: Sequence[Path], may_miss: bool) -> tuple[list[Path], list[str]]:
    """Paths to read, and names of files that are not there; where none may miss, reading refuses what is missing."""
    if not may_miss:
        return list(paths), []
    return [path for path in paths if path.exists()], [path.name for path in paths if not path.exists()]


@dataclass(frozen=True)
class Audit:
    """The audit of the paper: a table of any columns, and its data."""

    header: list[str]
    rows: list[list[str]]
    links: list[Link]


def show_audit(inputs: ReportInputs) -> Audit:
    """Read the audit."""
    path = inputs.results / "tables" / "audit.csv"
    rows = read_rows(path)
    columns = [name for name in next(iter(rows), {}) if name != "id"]
    links = [link(file, inputs.page) for file in (path, path.with_suffix(".tex")) if file.exists()]
    return Audit([name.replace("_", " ") for name in columns], [[row[name] for name in columns] for row in rows], links)


#: The paper's method as listed, and the opponent that the paper chose.
_PUBLISHED, _OPPONENT = "algorithm1", "least-squares"
_WORDS = {BETTER: "Yes", WORSE: "No", SAME: "Neither", OPEN: "Undecided"}


@dataclass(frozen=True)
class Pair:
    """One method against one opponent on all arms, after an identification of `duration` s."""

    method: str
    opponent: str
    duration: str
    difference: str  # points of a percent, with the simultaneous interval
    conclusion: str


@dataclass(frozen=True)
class Answer:
    """The answer in one sentence, and what it rests on."""

    words: str
    pairs: tuple[Pair, ...]


def answer(inputs: ReportInputs) -> Answer:
    """Read the comparisons."""
    path = inputs.results / "tables" / "verdict.csv"
    table = read_csv(path, COMPARISON_COLUMNS)
    table = table[table["set"] == ALL]
    asked = table[(table["method"] == _PUBLISHED) & (table["opponent"] == _OPPONENT)]
    if asked.empty:
        found = f"no {_PUBLISHED!r} against {_OPPONENT!r} on {SPAN}"
        raise InputError.at(f"{path}: method", found, f"rows of {_PUBLISHED}")
    conclusions = set(asked["conclusion"])
    yes = _WORDS[conclusions.pop()] if len(conclusions) == 1 else "Not throughout"
    parts = [f"{_points(row)} after {row['duration']:.4g} s" for row in asked.to_dict("records")]
    words = (
        f"{yes}: over {int(table['arms'].max())} simulated arms, Algorithm 1 as listed differs from least squares by "
        f"{' and '.join(parts)}."
    )
    return Answer(words, tuple(_pair(row) for row in table.to_dict("records")))


def _points(row: Mapping[Hashable, Any]) -> str:
    difference, low, high = (100.0 * float(row[name]) for name in ("difference", "low", "high"))
    return f"{difference:+.2f} points ({low:+.2f} to {high:+.2f})".replace("-", "\N{MINUS SIGN}")


def _pair(row: Mapping[Hashable, Any]) -> Pair:
    first, second = (
        METHODS[name].title if name in METHODS else name for name in (str(row["method"]), str(row["opponent"]))
    )
    return Pair(first, second, f"{row['duration']:.4g}", _points(row), str(row["conclusion"]))


def closing_lines(results: Path, figures: Path) -> list[str]:
    """Give what a run of every target ends with on the screen; nothing where the ledger was not made."""
    if not (results / "claims.csv").exists() or not (results / "tables/table10.csv").exists():
        return []
    scores = read_csv(results / "tables/table10.csv", ("case", "method", "joint", "total"))
    lines = ["", "Table 10, simulated arm: similarity in % on ID (both joints), and the mean of T1 to T4"]
    for method in ("algorithm1", "least-squares", "bounded"):
        own = scores[scores["method"] == method]
        on_id, unseen = (100.0 * own[rows]["total"] for rows in (own["case"] == "ID", own["case"] != "ID"))
        lines.append(f"  {METHODS[method].title:<64}{'  '.join(f'{x:.2f}' for x in on_id)}  {unseen.mean():.2f}")
    claims = pd.read_csv(results / "claims.csv", keep_default_na=False)
    numbers = claims.assign(ours=pd.to_numeric(claims["ours"], errors="coerce"))
    page = results / "report/index.html"
    places = (f"report: {page}", f"figures: {figures}", f"check: .venv/bin/repro verify --results {results}")
    return [*lines, "", *summary(numbers), "", *places]


_TEMPLATES = Path(__file__).parent


def build_report(inputs: ReportInputs) -> str:
    """Lay out the report."""
    ledger_file = inputs.results / "claims.csv"
    claims = read_claims(ledger_file)
    style, script = (Markup((_TEMPLATES / name).read_text("utf-8")) for name in ("report.css", "report.js"))
    tables = [show_table(exhibit, inputs) for exhibit in TABLES]
    figures, audit = show_figures(FIGURES, inputs), show_audit(inputs)
    templates = environment(_TEMPLATES)
    templates.filters["slug"] = lambda text: "-".join(str(text).split())
    text = templates.get_template("report.html").render(
        inputs=inputs,
        style=style,
        script=script,
        policy=policy(style, script),
        claims=claims,
        claims_link=link(ledger_file, inputs.page),
        counts=count(claims),
        numeric=tally(claims, Basis.NUMERIC),
        arm=tally(claims, Basis.ARM),
        asserted=[claim for claim in claims if claim.asserted],
        answer=answer(inputs),
        differing=differences(claims),
        audit=audit,
        tables=tables,
        figures=figures,
        targets=TARGETS,
        captures=_captures(inputs),
        provenance=list(_flat(inputs.provenance)),
    )
    size = len(text.encode())
    if size > LARGEST_REPORT:
        expected = f"{LARGEST_REPORT / 1e6:g} MB at most; the figures are what fills it"
        raise InputError.at(str(inputs.page), f"{size / 1e6:.1f} MB", expected)
    return text


def write_report(inputs: ReportInputs, path: Path | None = None) -> None:
    """Write the report."""
    write_text(path or inputs.page, build_report(inputs))


def _captures(inputs: ReportInputs) -> list[tuple[str, str]]:
    """Name and SHA-256 of every recorded file."""
    hashes = []
    for number, line in enumerate(read_text(inputs.captures, "SHA-256 sums").splitlines(), start=1):
        digest, _, name = line.partition("  ")
        if len(digest) != 64 or not name:
            raise InputError.at(f"{inputs.captures}: line {number}", repr(line), "a SHA-256, two blanks and a name")
        hashes.append((name, digest))
    return hashes


def _flat(content: Mapping[str, object], prefix: str = "") -> Iterator[tuple[str, str]]:
    """Every value of a nested mapping with its dotted name."""
    for name, value in content.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", str(value)


#: How a reader makes one output again.
COMMAND = "snakemake --cores 2"
#: Where the networks come from, by ``training.source``.
NETWORKS = {"trained": "trained in this run", "stored": "networks that come with the project, not trained in this run"}


def make_report(captures: str, checkout: str, overlays: Sequence[str], config: Config) -> None:
    """Write ``report/index.html`` in the results folder."""
    digest = hashlib.sha256(json.dumps(config, sort_keys=True).encode()).hexdigest()
    # No times: the same commit, configuration and results give the same page.
    provenance: Mapping[str, Any] = {
        "commit": commit(Path(checkout)),
        "networks": NETWORKS[config["training"]["source"]],
        "packages": package_versions(),
        "python": platform.python_version(),
    }
    names = ", ".join(Path(name).name for name in overlays)
    notice = f"Made with the settings of {names}, not those of the full reproduction." if overlays else ""
    if config["training"]["source"] == "stored":
        notice = f"{notice} {NETWORKS['stored'].capitalize()}.".strip()
    folders = (Path(config["results"]), Path(config["figures"]), Path(captures))
    write_report(ReportInputs(*folders, digest, COMMAND, provenance, notice))
