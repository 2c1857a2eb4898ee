"""Copy a full run into the repository: pictures to docs/gallery, tables to docs/reference, networks and sizes to data.

Usage, in the project's folder after ``snakemake --cores 2``: ``python docs/refresh.py``. With ``--ledger`` nothing is
copied: ledger and check sums of the reference, and the tables of the pages, are computed from what is there.
"""

import argparse
import shutil
from pathlib import Path

from long_results import LONG_RESULTS, record
from pages import write_pages
from PIL import Image

from repro.config.check import load_config, read_config
from repro.config.sections import plain
from repro.exhibits.catalogue import EXHIBITS
from repro.experiments.record import ASKED_FOR, config_digest
from repro.experiments.stored_networks import stored_files
from repro.files import write_json
from repro.paper.ledger import write_ledger
from repro.provenance import commit

#: Relative to the project, as the ledger's list of files is.
GALLERY, REFERENCE, CONFIG = Path("docs/gallery"), Path("docs/reference"), Path("config/config.yaml")
WIDTH = 800


def refresh_gallery() -> None:
    """Shrink every figure to the width of a page on a screen, in 256 colours."""
    GALLERY.mkdir(parents=True, exist_ok=True)
    for figure in sorted(Path("paper_figures").glob("*.png")):
        with Image.open(figure) as picture:
            height = round(picture.height * WIDTH / picture.width)
            small = picture.convert("RGB").resize((WIDTH, height), Image.Resampling.LANCZOS).quantize(256, kmeans=2)
            small.save(GALLERY / figure.name, optimize=True)


#: Files of a run, next to its tables, that a reader compares with and ledger and tables are computed from.
KEPT = (
    "model/training.csv",
    "model/model-card.md",
    "validation/*.csv",
    "accepted/methods.csv",
    "identification/*seed*.json",
)
COSTS = "logs/costs.csv"
TABLES, FIGURES = (
    [exhibit.name for exhibit in EXHIBITS if exhibit.optional and exhibit.kind == kind] for kind in ("table", "figure")
)
#: Pages of the tutorials with their figures, of target `tutorials`.
TUTORIALS = [
    f"tutorials/{script.stem}{end}" for script in Path("docs/tutorials").glob("*.py") for end in (".md", "-1.png")
]
#: What tables of targets that `all` does not make are computed from.
OUTCOMES = ("study/cells/*.csv", "accepted/experiment-*.csv", "factorial/*.csv")
OPTIONAL = (
    *(f"tables/{name}.{ext}" for name in TABLES for ext in ("csv", "md", "tex")),
    *(f"{name}.json" for name in ASKED_FOR),
    *(f"figures/{name}.csv" for name in FIGURES),
    *TUTORIALS,
)


def refresh_reference() -> None:
    """Copy what a reader compares their own run with."""
    config = load_config(CONFIG)
    results, made_by = Path(config.results), commit(Path())  # before the copy makes the folder differ
    outcomes = {name for run in (REFERENCE, results) for name in _files(run, *OUTCOMES)}
    asked_for = (*OPTIONAL, *sorted(outcomes))
    kept = {name: (REFERENCE / name).read_bytes() for name in asked_for if (REFERENCE / name).is_file()}
    shutil.rmtree(REFERENCE, ignore_errors=True)
    made = _files(results, *KEPT, COSTS, "tables/*.*")
    for name in (*made, *(name for name in asked_for if (results / name).exists())):
        (REFERENCE / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(results / name, REFERENCE / name)
    for name, content in kept.items():
        if not (REFERENCE / name).exists():
            (REFERENCE / name).parent.mkdir(parents=True, exist_ok=True)
            (REFERENCE / name).write_bytes(content)
    # A new result has the commit that made it; a file that did not change may be of an earlier run.
    for name in LONG_RESULTS:
        table = f"tables/{name}.csv"
        if table in OPTIONAL and (results / table).exists() and (results / table).read_bytes() != kept.get(table):
            record(name, made_by)
            if name in ASKED_FOR:
                digest = config_digest(read_config(CONFIG))
                write_json(REFERENCE / f"{name}.json", {"commit": made_by, "config_sha256": digest})
    shutil.copy(CONFIG, REFERENCE)
    shutil.copy(results / "logs/provenance.json", REFERENCE)


def _files(run: Path, *patterns: str) -> list[str]:
    return [path.relative_to(run).as_posix() for pattern in patterns for path in sorted(run.glob(pattern))]


def refresh_networks() -> None:
    """Copy the networks of the run with their histories and cards: what `make quick` takes instead of training."""
    config = load_config(CONFIG)
    for suffix in ("", *(f"-{name}" for name in plain(config.networks) if not name.startswith("paper-recipe"))):
        made = stored_files(Path(config.results) / "model", suffix)
        for what, path in stored_files(config.training.networks, suffix).items():
            if not made[what].exists():
                continue  # a network that is trained as another one has no files of its own
            path.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(made[what], path)


def refresh_board() -> None:
    """Copy the synthesis of the board in logic, of target `synthesise_board`, if the results have one."""
    made = Path(load_config(CONFIG).results) / "board/size.csv"
    if made.exists():
        shutil.copy(made, Path("data/board"))


def refresh_ledger() -> None:
    """Compute the ledger of the reference, and the check sums of everything that is kept."""
    config = load_config(CONFIG)
    write_ledger(REFERENCE, config, [], folders=[REFERENCE, GALLERY, Path("data")])


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--ledger", action="store_true", help="only compute ledger and check sums again")
    if not parser.parse_args().ledger:
        refresh_reference()
        refresh_networks()
        refresh_board()
        refresh_gallery()
    refresh_ledger()
    write_pages()
