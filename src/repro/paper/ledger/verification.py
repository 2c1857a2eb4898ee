"""The ledger on disk against everything it was made from: what is not as it was is named."""

import csv
import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from repro.errors import InputError
from repro.files import CSV_FLOAT_FORMAT, write_csv, write_text
from repro.fpga.checksums import SUMS, verify_folder
from repro.paper.ledger.counterparts import compute
from repro.paper.ledger.results import Results
from repro.paper.ledger.sums import changed_sources, read_sources, write_sources
from repro.paper.ledger.text import markdown
from repro.paper.published import PUBLISHED_FILE, load_published

CLAIMS, PAGE, SOURCES = "claims.csv", "claims.md", "claims.sha256"


def write_ledger(
    results: Path,
    config: Mapping[str, Any],
    files: Sequence[Path],
    root: Path = Path(),
    published: Path = PUBLISHED_FILE,
) -> pd.DataFrame:
    """Compute the ledger and write it: table, page and check sums of its sources.

    Parameters
    ----------
    results : Path
        Results folder; ``claims.csv``, ``claims.md`` and ``claims.sha256`` are written there.
    config : mapping
        Checked configuration.
    files : sequence of Path
        Files to list, relative to `root`: the results, and ``SHA256SUMS`` of the captures.
    root : Path
        Folder of the project.
    published : Path
        File of the published numbers.

    Returns
    -------
    DataFrame
        The ledger.

    Raises
    ------
    InputError
        If a file is missing or is not what it must be.
    """
    claims = compute(load_published(published), config, Results(results))
    write_csv(results / CLAIMS, claims)
    write_text(results / PAGE, markdown(claims))
    write_sources(results / SOURCES, files, root, published)
    return claims


def verify_ledger(
    results: Path, config: Mapping[str, Any], root: Path = Path(), published: Path = PUBLISHED_FILE
) -> tuple[pd.DataFrame | None, list[str]]:
    """Check every source of a ledger, compute it again and compare it with the one on disk, cell by cell.

    Parameters
    ----------
    results, config, root, published
        As for `write_ledger`.

    Returns
    -------
    claims : DataFrame or None
        The ledger computed again; None if its sources no longer allow that.
    problems : list of str
        A line for each file that is gone or changed, each capture that is not the recorded one, and each cell of
        the ledger that does not follow from its sources; empty if all agree.

    Raises
    ------
    InputError
        If there is no ledger, or no list of its sources, to check.
    """
    table, page = _text(results / CLAIMS), _text(results / PAGE)
    problems = changed_sources(results / SOURCES, root, published)
    for name in read_sources(results / SOURCES):
        if Path(name).name == SUMS:
            problems += _captures((root / name).parent)
    try:
        claims = compute(load_published(published), config, Results(results))
    except InputError as error:
        return None, [*problems, str(error)]
    problems += compare(table, claims, str(results / CLAIMS))
    if page != markdown(claims):
        problems.append(f"{results / PAGE}: found another text, expected the page of the ledger computed again")
    return claims, problems


def compare(text: str, claims: pd.DataFrame, place: str) -> list[str]:
    """Cells of a written ledger that are not those of a computed one.

    Parameters
    ----------
    text : str
        The written one, CSV.
    claims : DataFrame
        The computed one.
    place : str
        File, for messages.

    Returns
    -------
    list of str
        A line for each cell, row or column that differs, naming it.
    """
    written = list(csv.reader(io.StringIO(text)))
    computed = list(csv.reader(io.StringIO(claims.to_csv(index=False, float_format=CSV_FLOAT_FORMAT))))
    header = computed[0]
    if not written or written[0] != header:
        return [f"{place}: header: found {','.join(written[0]) if written else 'nothing'}, expected {','.join(header)}"]
    said = []
    for number, row in enumerate(written[1:], start=2):
        if len(row) != len(header):
            return [f"{place}: line {number}: found {len(row)} fields, expected {len(header)} fields"]
    theirs, ours = ({row[0]: row for row in rows[1:]} for rows in (written, computed))
    for name in ours.keys() | theirs.keys():
        if name not in theirs or name not in ours:
            found, expected = ("no row", "one") if name not in theirs else ("a row", "none")
            said.append(f"{place}: {name}: found {found}, expected {expected}")
            continue
        said += [
            f"{place}: {name}: {column}: found {found or 'nothing'}, expected {expected or 'nothing'}"
            for column, found, expected in zip(header, theirs[name], ours[name], strict=True)
            if found != expected
        ]
    if not said and [row[0] for row in written] != [row[0] for row in computed]:
        said.append(f"{place}: found rows in another order or twice, expected that of the published numbers")
    return sorted(said)


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
