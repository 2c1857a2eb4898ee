"""The ledger on disk against everything it was made from: what is not as it was is named."""

import csv
import hashlib
import io
import logging
import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from repro.comparison.classes import Spread
from repro.comparison.tables import differences
from repro.errors import InputError
from repro.files import CSV_FLOAT_FORMAT, write_csv, write_text
from repro.fpga.checksums import SUMS, verify_folder
from repro.paper.claims import broken, specificity
from repro.paper.ledger.counterparts import compute
from repro.paper.ledger.results import Results
from repro.paper.ledger.text import markdown, summary
from repro.paper.published import PUBLISHED_FILE, Published, load_published

#: Name of the published numbers in the list: where they lie in the project's folder.
PUBLISHED_NAME = "src/repro/paper/published.csv"


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def write_sources(path: Path, files: Iterable[Path], root: Path = Path(), published: Path = PUBLISHED_FILE) -> None:
    """Write the check sums of files and of the published numbers."""
    sums = {PUBLISHED_NAME: published, **{file.as_posix(): root / file for file in files}}
    lines = []
    for name, file in sorted(sums.items()):
        try:
            lines.append(f"{_digest(file)}  {name}\n")
        except OSError as error:
            raise InputError.at(str(file), error.strerror or "an unreadable file", "what the ledger is from") from error
    write_text(path, "".join(lines))


def read_sources(path: Path) -> dict[str, str]:
    """Names and check sums of a list."""
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise InputError.at(str(path), f"no readable list ({error})", "check sums of the ledger's sources") from error
    listed = {}
    for number, line in enumerate(lines, start=1):
        digest, separator, name = line.partition("  ")
        if not separator or len(digest) != 64 or not name:
            raise InputError.at(f"{path}: line {number}", repr(line), "a SHA-256, two spaces and a file name")
        listed[name] = digest
    if PUBLISHED_NAME not in listed:
        raise InputError.at(str(path), f"no line of {PUBLISHED_NAME}", "one")
    return listed


def changed_sources(path: Path, root: Path = Path(), published: Path = PUBLISHED_FILE) -> list[str]:
    """Files of a list that are gone or changed."""
    said = []
    for name, digest in read_sources(path).items():
        file = published if name == PUBLISHED_NAME else root / name
        try:
            found = _digest(file)
        except OSError as error:
            said.append(f"{name}: found {error.strerror or 'an unreadable file'}, expected the file that {path} lists")
            continue
        if found != digest:
            said.append(f"{name}: SHA-256: found {found}, expected the {digest} of {path}")
    return said


_LOG = logging.getLogger(__name__)

CLAIMS, PAGE, SOURCES = "claims.csv", "claims.md", "claims.sha256"


def write_ledger(
    results: Path,
    config: Mapping[str, Any],
    files: Sequence[Path],
    root: Path = Path(),
    published: Path = PUBLISHED_FILE,
) -> pd.DataFrame:
    """Compute the ledger and write it: table, page and check sums of its sources."""
    numbers = load_published(published)
    claims = compute(numbers, config, Results(results))
    write_csv(results / CLAIMS, claims)
    write_text(results / PAGE, _page(_csv(claims), numbers))
    folder = results.relative_to(root) if results.is_relative_to(root) else results
    write_sources(results / SOURCES, [*files, folder / CLAIMS, folder / PAGE], root, published)
    return claims


def verify_ledger(
    results: Path, config: Mapping[str, Any], root: Path = Path(), published: Path = PUBLISHED_FILE
) -> tuple[pd.DataFrame | None, list[str]]:
    """Check every source of a ledger, compute it again and compare it with the one on disk, cell by cell."""
    table, page = _text(results / CLAIMS), _text(results / PAGE)
    problems = changed_sources(results / SOURCES, root, published)
    for name in read_sources(results / SOURCES):
        if Path(name).name == SUMS:
            problems += _captures((root / name).parent)
    try:
        numbers = load_published(published)
        claims = compute(numbers, config, Results(results))
    except InputError as error:
        return None, [*problems, str(error)]
    problems += compare(table, claims, str(results / CLAIMS))
    if not problems and page != _page(table, numbers):
        problems.append(f"{results / PAGE}: found another text, expected the page of {CLAIMS}")
    return claims, problems


def compare(text: str, claims: pd.DataFrame, place: str) -> list[str]:
    """Cells of a written ledger that are not those of a computed one, beyond what rounding makes of them."""
    header, found = ",".join(claims.columns), text.partition("\n")[0].strip()
    if found != header:
        return [f"{place}: header: found {found or 'nothing'}, expected {header}"]
    written, computed = (_rows(each, place) for each in (text, _csv(claims)))
    theirs, ours = ({row["id"]: row for row in rows} for rows in (written, computed))
    said = []
    for name in ours.keys() | theirs.keys():
        if name not in theirs or name not in ours:
            found, expected = ("no row", "one") if name not in theirs else ("a row", "none")
            said.append(f"{place}: {name}: found {found}, expected {expected}")
            continue
        # Both follow from the same files, so that even what was trained is no more than computed here.
        for d in differences("", [theirs[name]], [ours[name]], Spread({})):
            if d.broken:
                column, by = d.place.rpartition(", ")[2], "" if math.isinf(d.size) else f", {d.size:.2g} away"
                said.append(f"{place}: {name}: {column}: found {d.a or 'nothing'}, expected {d.b or 'nothing'}{by}")
    if not said and [row["id"] for row in written] != [row["id"] for row in computed]:
        said.append(f"{place}: found rows in another order or twice, expected that of the published numbers")
    return sorted(said)


def _csv(claims: pd.DataFrame) -> str:
    return claims.to_csv(index=False, float_format=CSV_FLOAT_FORMAT, lineterminator="\n")


def _page(text: str, numbers: Published) -> str:
    claims = _written(text)
    return markdown(claims, specificity(claims, numbers))


def _written(text: str) -> pd.DataFrame:
    """The ledger as its CSV has it, ten digits of each number: what the page shows."""
    claims = pd.read_csv(io.StringIO(text), dtype=str, keep_default_na=False)
    for column in ("ours", "difference", "tolerance"):
        claims[column] = pd.to_numeric(claims[column])
    return claims


def _rows(text: str, place: str) -> list[dict[str, str]]:
    rows = list(csv.DictReader(io.StringIO(text)))
    for number, row in enumerate(rows, start=2):
        if None in row or None in row.values():
            raise InputError.at(f"{place}: line {number}", "another number of fields", "as many as in the header")
    return rows


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except OSError as error:
        raise InputError.at(str(path), error.strerror or "an unreadable file", "a ledger (target claims)") from error
    except UnicodeDecodeError as error:
        raise InputError.at(str(path), "bytes that are not UTF-8", "a ledger (target claims)") from error


def _captures(folder: Path) -> list[str]:
    try:
        verify_folder(folder)
    except InputError as error:
        return [str(error)]
    except OSError as error:
        return [f"{folder}: found {error.strerror or 'an unreadable folder'}, expected the captures"]
    return []


def verified(results: Path, config: Mapping[str, Any]) -> str:
    """Summarise a ledger that follows from its sources; if the configuration enforces it, asserted claims must hold."""
    claims, problems = verify_ledger(results, config)
    for problem in problems:
        _LOG.error("%s", problem)
    if problems or claims is None:
        found = f"{len(problems)} disagreements with its sources, named above"
        raise InputError.at(f"{results}: ledger", found, "none")
    lines, failed = summary(claims), len(broken(claims))
    if failed and config["claims"]["enforce"]:
        for line in lines:
            _LOG.error("%s", line)
        raise InputError.at(f"{results}/claims.csv: asserted", f"{failed} claims that fail", "none")
    return "".join(f"{line}\n" for line in lines)
