"""The report of a run as one HTML text: every result, with what it was made by."""

import hashlib
import json
import platform
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from jinja2 import Environment
from markupsafe import Markup

from repro.errors import InputError
from repro.exhibits.catalogue import FIGURES, TABLES, TARGETS
from repro.files import write_text
from repro.pipeline.job import Config
from repro.pipeline.provenance import commit, package_versions
from repro.report.embed import environment, link, policy
from repro.report.exhibits import Shown, show_audit, show_figures, show_tables
from repro.report.inputs import LARGEST_REPORT, ReportInputs, read_text
from repro.report.ledger import count, differences, read_claims
from repro.report.question import answer

_TEMPLATES = Path(__file__).parent


def build_report(inputs: ReportInputs) -> str:
    """Lay out the report."""
    claims = read_claims(inputs)
    style, script = (_read_own(name) for name in ("report.css", "report.js"))
    ledger_file = inputs.results / "claims.csv"
    tables, figures, audit = show_tables(TABLES, inputs), show_figures(FIGURES, inputs), show_audit(inputs)
    text = (
        _environment()
        .get_template("report.html")
        .render(
            inputs=inputs,
            style=style,
            script=script,
            policy=policy(style, script),
            claims=claims,
            claims_link=link(ledger_file, inputs.page) if claims else None,
            counts=count(claims),
            asserted=[claim for claim in claims if claim.asserted],
            answer=answer(inputs),
            differing=differences(claims),
            audit=audit,
            tables=tables,
            figures=figures,
            missing=_missing(tables + figures, bool(claims), audit is not None),
            targets=TARGETS,
            captures=_captures(inputs),
            provenance=list(_flat(inputs.provenance)),
        )
    )
    size = len(text.encode())
    if size > LARGEST_REPORT:
        expected = f"{LARGEST_REPORT / 1e6:g} MB at most; the figures are what fills it"
        raise InputError.at(str(inputs.page), f"{size / 1e6:.1f} MB", expected)
    return text


def write_report(inputs: ReportInputs, path: Path | None = None) -> None:
    """Write the report."""
    write_text(path or inputs.page, build_report(inputs))


def _read_own(name: str) -> Markup:
    return Markup((_TEMPLATES / name).read_text(encoding="utf-8"))


def _environment() -> Environment:
    filled = environment(_TEMPLATES)
    filled.filters["slug"] = lambda text: "-".join(str(text).split())
    return filled


def _missing(shown: list[Shown], claims: bool, audit: bool) -> list[tuple[str, str]]:
    """Name and anchor of everything that ought to be there and is not."""
    lost = [] if claims else [("claims.csv", "claims")]
    lost += [] if audit else [("audit.csv", "audit")]
    for item in shown:
        if not item.exhibit.optional:
            lost += [(name, item.exhibit.target) for name in item.missing]
    return lost


def _captures(inputs: ReportInputs) -> list[tuple[str, str]]:
    """Name and SHA-256 of every recorded file."""
    if inputs.partial and not inputs.captures.exists():
        return []
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
