"""Write the files of a result."""

import re
from collections.abc import Iterable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from repro.export import horizontal_links_of, links_of, mjcf, urdf
from repro.files import fill_folder, write_csv, write_json, write_text
from repro.fingerprint import fingerprint
from repro.logs.armfile import Arm
from repro.ownarm.figures import figures_of
from repro.ownarm.page import render_page
from repro.ownarm.result import Curves, Result
from repro.ownarm.tables import parameters_table, residuals_table, runs_table, scores_table
from repro.ownarm.text import COMBINED, NOT_EXCITED
from repro.pipeline.provenance import write_provenance

PAGE = "report.html"
#: BibTeX entries of the methods.
METHODS_FILE = Path(__file__).with_name("methods.bib")
#: Files that are written or not, as the result has it.
OPTIONAL = {"arm.urdf", "arm.xml", "no-links.txt", "runs.csv"}
#: File next to a result with the versions that computed it.
SIDECAR = "provenance.json"

#: BibTeX keys of every result, of the intervals, and of the solvers of some methods.
ALWAYS = ("cnn_identification",)
INTERVALS = ("kunsch1989jackknife", "kott2001delete", "jcgm2008gum", "baranchik1970family", "cook1994simex")
SOLVERS = {
    "consistent": ("diamond2016cvxpy", "goulart2024clarabel"),
    "parsimonious": ("diamond2016cvxpy", "goulart2024clarabel"),
    "algorithm1+refinement": ("storn1997differential",),
}


def write_result(out: Path, result: Result, curves: Curves, arm: Arm, inputs: Iterable[Path] = ()) -> list[str]:
    """Write every file of a result, or none; no input is replaced."""
    return fill_folder(out, lambda folder: _write_files(folder, result, curves, arm), OPTIONAL, inputs)


def _write_files(folder: Path, result: Result, curves: Curves, arm: Arm) -> None:
    write_json(folder / "parameters.json", _jsonable(asdict(result)))
    write_csv(folder / "parameters.csv", parameters_table(result))
    write_csv(folder / "scores.csv", scores_table(result))
    write_csv(folder / "residuals.csv", residuals_table(result, curves))
    if result.spread:
        write_csv(folder / "runs.csv", runs_table(result))
    write_text(folder / "methods.bib", bibtex(citations(result)))
    _write_links(folder, result, arm)
    names = sorted(path.name for path in folder.iterdir())
    write_text(folder / PAGE, render_page(result, curves, figures_of(result, curves), names))
    write_provenance(folder / SIDECAR, Path(__file__).parent, 1, fingerprint())


def citations(result: Result) -> list[str]:
    """List the BibTeX keys of everything that a result relies on."""
    keys = [*ALWAYS]
    for method in result.methods:
        keys += [method.citation, *SOLVERS.get(method.method, ())]
    if any(method.claims_intervals for method in result.methods):
        keys += INTERVALS
    if result.preparation.filter.startswith("Savitzky"):
        keys.append("savitzky1964smoothing")
    return list(dict.fromkeys(keys))


def entries() -> dict[str, str]:
    """Read every entry of ``methods.bib``, by key in the order of the file."""
    # An entry starts with @type{key, in the first column and ends with the next brace there.
    text = METHODS_FILE.read_text(encoding="utf-8")
    return {m[1]: m[0] for m in re.finditer(r"^@\w+\{([^,\s]+),.*?^\}", text, re.DOTALL | re.MULTILINE)}


def bibtex(keys: Sequence[str]) -> str:
    """Write the entries of some keys."""
    known = entries()
    missing = [key for key in keys if key not in known]
    if missing:
        raise ValueError(f"keys: no BibTeX entry {missing[0]!r}; there are {', '.join(known)}.")
    return "".join(f"{known[key]}\n\n" for key in dict.fromkeys(keys)).removesuffix("\n")


def _write_links(folder: Path, result: Result, arm: Arm) -> None:
    """Write URDF and MJCF if a set of two links has these parameters, else a file with the reason."""
    unknown = [p.name for p in result.best.parameters[:5] if p.verdict in (NOT_EXCITED, COMBINED)]
    beta = np.array([p.estimate for p in result.best.parameters])
    reason = f"The motion does not determine {', '.join(unknown)}, which masses and lengths depend on."
    if not unknown:
        try:
            if arm.plane == "horizontal":
                links = horizontal_links_of(beta, arm.link_lengths)
            else:
                links = links_of(beta, arm.gravity, arm.link_lengths)
        except ValueError as error:
            reason = f"No two links have these parameters. {error}"
        else:
            write_text(folder / "arm.urdf", urdf(links, result.arm))
            write_text(folder / "arm.xml", mjcf(links, result.arm))
            return
    write_text(folder / "no-links.txt", f"No URDF or MJCF. {reason}\n")


def _jsonable(value: Any) -> Any:  # noqa: ANN401
    """Replace tuples by lists, and numbers that JSON does not know by null."""
    if isinstance(value, dict):
        return {key: _jsonable(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_jsonable(item) for item in value]
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value
