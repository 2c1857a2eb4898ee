"""The files of a result: all of them or none."""

import tempfile
from collections.abc import Callable, Iterable, Set
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from repro.errors import InputError
from repro.export.bibtex import bibtex
from repro.export.links import links_of
from repro.export.models import mjcf, urdf
from repro.files import write_csv, write_json, write_text, writing
from repro.fingerprint import fingerprint
from repro.logs.armfile import Arm
from repro.ownarm.figures import figures_of
from repro.ownarm.page import render_page
from repro.ownarm.result import Curves, Result
from repro.ownarm.tables import cell, parameters_table, scores_table
from repro.ownarm.words import COMBINED, NOT_EXCITED
from repro.pipeline.provenance import write_provenance

PAGE = "report.html"

#: Room that is tested before the work begins, bytes: what a usual result takes.
_ROOM = 8 << 20
#: Files that are written or not, as the result has it.
EITHER = {"arm.urdf", "arm.xml", "no-links.txt"}

#: Sources of what every run uses, beside those of its methods.
ALWAYS = ("cnn_identification",)
#: Sources of the intervals.
INTERVALS = ("kunsch1989jackknife", "kott2001delete", "jcgm2008gum", "baranchik1970family", "cook1994simex")
SOLVERS = {
    "consistent": ("diamond2016cvxpy", "goulart2024clarabel"),
    "parsimonious": ("diamond2016cvxpy", "goulart2024clarabel"),
    "algorithm1+refinement": ("storn1997differential",),
}


#: File next to a result that says which versions made it.
SIDECAR = "provenance.json"


def check_folder(out: Path, overwrite: bool) -> None:
    """Refuse a folder that holds anything, unless told to replace what we write."""
    with writing(out):
        there = out.exists()
        if out.is_symlink() and not there:
            raise InputError.at(str(out), "a link to nothing", "a folder, or a name that is free")
        if there and not out.is_dir():
            raise InputError.at(str(out), "a file", "a folder, or a name that is free")
        if there and not overwrite and any(out.iterdir()):
            raise InputError.at(str(out), "a folder with files in it", "a new or empty folder, or --overwrite")
        with _near(out) as made:
            (Path(made) / "room").write_bytes(bytes(_ROOM))


def _near(out: Path) -> tempfile.TemporaryDirectory[str]:
    """New folder on the disk of `out`, which is filled before its files are put into `out`."""
    near = next(parent for parent in out.absolute().parents if parent.exists())
    if out.exists() and out.stat().st_dev != near.stat().st_dev:  # another file system: files cannot be moved there
        near = out
    return tempfile.TemporaryDirectory(prefix=".repro-", suffix=".partial", dir=near)


def write_all(out: Path, result: Result, curves: Curves, arm: Arm, inputs: Iterable[Path] = ()) -> list[str]:
    """Write every file of a result, then put them in place; none of the inputs is replaced."""
    return put(out, lambda made: _fill(made, result, curves, arm), EITHER, inputs)


def put(
    out: Path, fill: Callable[[Path], None], either: Set[str] = frozenset(), inputs: Iterable[Path] = ()
) -> list[str]:
    """Let `fill` write into a folder beside `out`, then put its files in place; of `either` no older one stays."""
    given = {path.resolve() for path in inputs}
    with writing(out), _near(out) as folder:
        made = Path(folder)
        fill(made)
        names = sorted(path.name for path in made.iterdir())
        for name in (*names, *either, SIDECAR):
            if (out / name).resolve() in given:
                raise InputError.at(str(out / name), "an input of this command", "another folder for the results")
        out.mkdir(parents=True, exist_ok=True)
        for name in either - set(names):  # of an earlier run, which this one contradicts
            (out / name).unlink(missing_ok=True)
        for name in names:
            (made / name).replace(out / name)
        return names


def write_sidecar(out: Path) -> str:
    """Write which versions made a result, and when, beside it."""
    name = SIDECAR
    with writing(out):
        write_provenance(out / name, Path(__file__).parent, 1, fingerprint())
    return name


def _fill(folder: Path, result: Result, curves: Curves, arm: Arm) -> None:
    write_json(folder / "parameters.json", _plain(asdict(result)))
    write_csv(folder / "parameters.csv", parameters_table(result))
    write_csv(folder / "scores.csv", scores_table(result))
    write_csv(folder / "residuals.csv", residuals(result, curves))
    write_text(folder / "methods.bib", bibtex(citations(result)))
    _export(folder, result, arm)
    names = sorted(path.name for path in folder.iterdir())
    write_text(folder / PAGE, render_page(result, curves, figures_of(result, curves), names))


def citations(result: Result) -> list[str]:
    """BibTeX keys of everything a result rests on."""
    keys = [*ALWAYS]
    for method in result.methods:
        keys += [method.citation, *SOLVERS.get(method.method, ())]
    if any(method.claims_intervals for method in result.methods):
        keys += INTERVALS
    if result.preparation.filter.startswith("Savitzky"):
        keys.append("savitzky1964smoothing")
    return list(dict.fromkeys(keys))


def residuals(result: Result, curves: Curves) -> pd.DataFrame:
    """Measured and rebuilt torque of the recommended method, log by log.

    Columns ``log, time_s, joint, torque_nm, rebuilt_nm, residual_nm``.
    """
    frames = []
    for signals in curves.signals:
        for joint in range(2):
            tau, rebuilt = signals.tau[joint], signals.rebuilt[result.recommended][joint]
            frames.append(
                pd.DataFrame(
                    {
                        "log": cell(signals.name),
                        "time_s": signals.t,
                        "joint": joint + 1,
                        "torque_nm": tau,
                        "rebuilt_nm": rebuilt,
                        "residual_nm": tau - rebuilt,
                    }
                )
            )
    return pd.concat(frames, ignore_index=True)


def _export(folder: Path, result: Result, arm: Arm) -> None:
    """URDF and MJCF where a set of two links has these parameters; else a file that says why not."""
    best = next(m for m in result.methods if m.method == result.recommended)
    unknown = [p.name for p in best.parameters[:5] if p.verdict in (NOT_EXCITED, COMBINED)]
    if unknown:
        why = f"{', '.join(unknown)}: not determined by this motion, and masses and lengths would rest on it"
        write_text(folder / "no-links.txt", f"No URDF or MJCF. {why}.\n")
        return
    beta = np.array([p.estimate for p in best.parameters])
    try:
        links = links_of(beta, arm.gravity, arm.link_lengths)
    except ValueError as error:
        write_text(folder / "no-links.txt", f"No URDF or MJCF: no two links have these parameters. {error}\n")
        return
    write_text(folder / "arm.urdf", urdf(links, result.arm))
    write_text(folder / "arm.xml", mjcf(links, result.arm))


def _plain(value: Any) -> Any:  # noqa: ANN401
    """Tuples as lists, numbers that JSON does not know as null."""
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value
