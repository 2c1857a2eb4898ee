"""The claims ledger: computed from its sources, written with their check sums, and verified cell by cell."""

import errno
import hashlib
import logging
import math
import os
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path

import pandas as pd

from repro.comparison import Tolerances, differences
from repro.config.model import Configuration
from repro.documents import read_bytes
from repro.errors import InputError, failure
from repro.files import LARGEST_TABLE, csv_text, parse_rows, write_text
from repro.paper.audit import findings
from repro.paper.claims import (
    EXTENSION,
    LEFT_OUT,
    NOT_REFUTED,
    REPRODUCED,
    SETTING,
    broken,
    judge_all,
    markdown,
    specificity,
    summary,
)
from repro.paper.finding import CONTRADICTS, NOT_POSSIBLE, Finding
from repro.paper.our_results import REFINED, Results, Values
from repro.paper.our_values import our_values
from repro.paper.published import PUBLISHED_FILE, Published, load_published

_LOG = logging.getLogger(__name__)

CLAIMS, PAGE, SOURCES = "claims.csv", "claims.md", "claims.sha256"
#: Name of the published numbers in the list: where they lie in the project's folder.
PUBLISHED_NAME = "src/repro/paper/published.csv"
_WHOLE = "# every file in "

#: Kinds of number that are asserted wherever we have a value.
ASSERTED_KINDS = (SETTING, "exact", "deterministic")
#: Asserted of the numeric tests: the listed algorithm is not below the abstract's mean, and our refinement reaches it.
#: The central claim about the arm is asserted where it is computed, in the sense that it is not reproduced.
ASSERTED = {"abstract/numeric/total": NOT_REFUTED, f"abstract/numeric/total{REFINED.suffix}": REPRODUCED}
#: Numbers that findings of another name refute.
_REFUTED = {"appendix/sine": "appendix/domain"}


def _in_order(published: Published, ours: Values) -> Values:
    """Our values in the order of the published numbers: each number of the paper's own has one."""
    order = {number.id: place for place, number in enumerate(published) if number.kind != LEFT_OUT}
    names = {name: name.partition(EXTENSION)[0] for name in ours}
    for name in sorted(order.keys() - set(names.values())):
        raise InputError.at(f"{published.source}: id", repr(name), "a number that repro.paper.our_values computes")
    return {name: ours[name] for name in sorted(ours, key=lambda name: order[names[name]])}


def _audited(published: Published, ours: Values, audit: Sequence[Finding]) -> Values:
    """Our values with what the audit finds about the published ones, and the verdicts that the project asserts."""
    refuted = {refuted_number(finding): finding for finding in audit}
    impossible = {id_: _sentence(f) for f in audit if f.verdict == NOT_POSSIBLE for id_ in f.numbers}
    audited = dict(ours)
    for number in published:
        value = ours.get(number.id)
        if value is None:
            continue
        finding = refuted.get(number.id)
        if finding is not None:
            size = abs(finding.found - finding.printed) / (math.pi if number.unit == "pi rad" else 1.0)
            size = math.inf if math.isnan(size) else size  # words contradict each other
            value = replace(value, contradicts=_sentence(finding), contradiction=size)
        elif number.id in impossible:
            value = replace(value, note=f"{value.note}; not possible: {impossible[number.id]}")
        compared = not (math.isnan(value.value) or finding or value.unused or value.literal)
        if number.kind in ASSERTED_KINDS and compared:
            value = replace(value, asserted=REPRODUCED)
        audited[number.id] = value
    for name, verdict in ASSERTED.items():
        audited[name] = replace(audited[name], asserted=verdict)
    return audited


def refuted_number(finding: Finding) -> str:
    """Id of the one published number that a finding proves wrong, or empty; of a Total and its factors, the Total."""
    if finding.id in _REFUTED:
        return _REFUTED[finding.id]
    name = finding.id.removeprefix("composition/")
    return name if finding.verdict == CONTRADICTS and name in finding.numbers else ""


def _sentence(finding: Finding) -> str:
    return f"{finding.arithmetic}. {finding.note}".removesuffix(". ").rstrip(".")


def compute(published: Published, config: Configuration, results: Results) -> pd.DataFrame:
    """Compute the ledger from its sources."""
    audit = findings(published)
    ours = our_values(published, config, {finding.id: finding.found for finding in audit}, results)
    return judge_all(published, _audited(published, _in_order(published, ours), audit))


def _digest(path: Path) -> str:
    if path.exists() and not path.is_file():
        raise OSError(errno.EINVAL, "a pipe or a device")
    return hashlib.sha256(path.read_bytes()).hexdigest()


def write_sources(path: Path, files: Iterable[Path], folders: Iterable[Path], root: Path = Path()) -> None:
    """Write the check sums of files, of every file in folders, and of the published numbers.

    For ``sha256sum --check`` the first lines are comments: the check sum of all others, then the folders.
    """
    folders = set(folders)
    whole = sorted(folder.as_posix() for folder in folders if folders.isdisjoint(folder.parents))
    lines = [f"{_WHOLE}{folder}\n" for folder in whole]
    inside = {name for folder in whole for name in _files_in(folder, root / folder, path)}
    # Relative to the project's folder, if they are in there.
    single = {(file.relative_to(root) if file.is_relative_to(root) else file).as_posix() for file in files}
    for name in sorted({PUBLISHED_NAME, *single, *inside}):
        file = PUBLISHED_FILE if name == PUBLISHED_NAME else root / name
        try:
            lines.append(f"{_digest(file)}  {name}\n")
        except OSError as error:
            raise InputError.at(str(file), failure(error), "a source of the ledger") from error
    write_text(path, _seal("".join(lines)) + "".join(lines))


def _seal(lines: str) -> str:
    return f"# SHA-256 of the lines below: {hashlib.sha256(lines.encode()).hexdigest()}\n"


def _files_in(name: str, folder: Path, path: Path) -> set[str]:
    """Name every file in a folder of that name, except the list itself."""
    own = os.path.realpath(path)
    inside = (file for file in folder.rglob("*") if file.is_file() and os.path.realpath(file) != own)
    return {f"{name}/{file.relative_to(folder).as_posix()}" for file in inside}


def read_sources(path: Path) -> tuple[list[str], dict[str, str]]:
    """Read the folders that a list covers completely, and its check sums by name."""
    seal, _, lines = _text(path).partition("\n")
    if f"{seal}\n" != _seal(lines):
        raise InputError.at(f"{path}: line 1", seal or "nothing", _seal(lines).strip())
    folders, sums = [], {}
    for number, line in enumerate(lines.splitlines(), start=2):
        digest, _, name = line.partition("  ")
        if line.startswith(_WHOLE):
            name = line.removeprefix(_WHOLE)
            folders.append(name)
        elif not line.startswith("#"):
            sums[name] = digest
        if not name.isprintable() or ".." in Path(name).parts:
            found = repr(name)[:80]
            raise InputError.at(f"{path}: line {number}", found, "the name of a file or folder of the project")
    return folders, sums


def changed_sources(path: Path, root: Path = Path(), stored: Iterable[Path] = ()) -> list[str]:
    """List files that are missing or changed, and those in the list's folders that it does not contain."""
    folders, listed = read_sources(path)
    # Where the ledger was when the list was written: a copy of the results is checked itself, not its original.
    own = next((Path(name).parent for name in listed if Path(name).name == CLAIMS), None)
    readable = [Path("data"), Path("docs"), *stored, *filter(None, [own])]
    for name in {*folders, *listed} - {PUBLISHED_NAME}:
        if not any(Path(name).is_relative_to(folder) for folder in readable):
            raise InputError.at(str(path), repr(name)[:80], f"names in {', '.join(map(str, readable))}")

    def place(name: str) -> Path:
        if own is not None and Path(name).is_relative_to(own):
            return path.parent / Path(name).relative_to(own)
        return PUBLISHED_FILE if name == PUBLISHED_NAME else root / name

    inside = {name for folder in folders for name in _files_in(folder, place(folder), path)}
    problems = []
    for name in sorted(listed.keys() | inside):
        file = place(name)
        shown = file if name != PUBLISHED_NAME and os.path.realpath(file) != os.path.realpath(root / name) else name
        try:
            found = _digest(file)
        except OSError as error:
            found = failure(error)
            problems.append(f"{shown}: found {found}, expected the file that {path} lists")
            continue
        if name not in listed:
            problems.append(f"{shown}: found a file, expected only those that {path} lists")
        elif found != listed[name]:
            problems.append(f"{shown}: SHA-256: found {found}, expected the {listed[name]} of {path}")
    return problems


def stored_folders(config: Configuration) -> list[Path]:
    """List the folders of the project that a run reads instead of measuring or training."""
    places = (
        (config.experiment.source, config.experiment.captures),
        (config.training.source, config.training.networks),
    )
    return [Path(folder) for source, folder in places if source == "stored"]


def write_ledger(
    results: Path,
    config: Configuration,
    files: Sequence[Path],
    root: Path = Path(),
    *,
    folders: Sequence[Path] = (),
) -> None:
    """Compute the ledger and write it: table, page and check sums of its sources, the stored ones among them."""
    numbers = load_published(PUBLISHED_FILE)
    text = csv_text(compute(numbers, config, Results(results)))
    write_text(results / CLAIMS, text)
    write_text(results / PAGE, _page(text, numbers))
    files = [*files, results / CLAIMS, results / PAGE]
    write_sources(results / SOURCES, files, [*folders, *stored_folders(config)], root)


def verify_ledger(results: Path, config: Configuration, root: Path = Path()) -> tuple[pd.DataFrame | None, list[str]]:
    """Check every source of a ledger, compute it again and compare it with the file, cell by cell."""
    table, page = _text(results / CLAIMS), _text(results / PAGE)
    problems = changed_sources(results / SOURCES, root, stored_folders(config))
    try:
        numbers = load_published(PUBLISHED_FILE)
        claims = compute(numbers, config, Results(results))
    except (ValueError, LookupError) as error:  # published numbers that were changed are named among the problems
        return None, [*problems, str(error)]
    problems += compare(table, claims, str(results / CLAIMS))
    if not problems and page != _page(table, numbers):
        problems.append(f"{results / PAGE}: found another text, expected the page of {CLAIMS}")
    return claims, problems


def compare(text: str, claims: pd.DataFrame, place: str) -> list[str]:
    """List the cells of a written ledger that differ from a computed one by more than rounding."""
    header, found = ",".join(claims.columns), text.partition("\n")[0].strip()
    if found != header:
        return [f"{place}: header: found {found or 'nothing'}, expected {header}"]
    written, computed = (parse_rows(each, place) for each in (text, csv_text(claims)))
    theirs, ours = ({row["id"]: row for row in rows} for rows in (written, computed))
    problems = [f"{place}: {name}: found no row, expected one" for name in ours.keys() - theirs.keys()]
    problems += [f"{place}: {name}: found a row, expected none" for name in theirs.keys() - ours.keys()]
    for name in ours.keys() & theirs.keys():
        # Both follow from the same files, so that even what was trained is no more than computed here.
        for d in differences("", [theirs[name]], [ours[name]], Tolerances()):
            if d.broken:
                column, by = d.place.rpartition(", ")[2], "" if math.isinf(d.size) else f", {d.size:.2g} away"
                problems.append(f"{place}: {name}: {column}: found {d.a or 'nothing'}, expected {d.b or 'nothing'}{by}")
    if not problems and [row["id"] for row in written] != [row["id"] for row in computed]:
        problems.append(f"{place}: found rows in another order or twice, expected that of the published numbers")
    return sorted(problems)


def _page(text: str, numbers: Published) -> str:
    """Format the page from the text of the table, so that both show the same ten digits."""
    claims = pd.DataFrame(parse_rows(text, CLAIMS))
    for column in ("ours", "difference", "tolerance"):
        claims[column] = pd.to_numeric(claims[column])
    return markdown(claims, specificity(claims, numbers))


#: What makes the ledger of a results folder, by its name; of another one it is the target ``claims`` of the workflow.
_MADE_BY = {"results": "make reproduce", "quick": "make quick", "smoke": "make smoke", "golden": "make golden"}


def _text(path: Path) -> str:
    expected = f"a ledger ({_MADE_BY.get(path.absolute().parent.name, 'target claims')})"
    try:
        return read_bytes(path, LARGEST_TABLE, expected).decode()  # line ends as they are
    except UnicodeDecodeError as error:
        raise InputError.at(str(path), "bytes that are not UTF-8", expected) from error


def verified(results: Path, config: Configuration) -> str:
    """Summarise a ledger that follows from its sources; if the configuration enforces it, asserted claims must hold."""
    claims, problems = verify_ledger(results, config)
    for problem in problems:
        _LOG.error("%s", problem)
    if problems or claims is None:
        found = f"{len(problems)} disagreements with its sources, named above"
        raise InputError.at(f"{results}: ledger", found, "none")
    lines, failed = summary(claims), len(broken(claims))
    if failed and config.claims.enforce:
        for line in lines:
            _LOG.error("%s", line)
        raise InputError.at(f"{results}/claims.csv: asserted", f"{failed} claims that fail", "none")
    return "".join(f"{line}\n" for line in lines)
