"""Long results that `all` does not make: the code and settings of each that is kept, and whether these changed since.

``docs/long_results/NAME.json`` has the commit that made a result, a digest of each definition of its code, and one of
its settings and files. ``docs/refresh.py`` writes it when it copies such a result. A reason, under ``older``, makes it
an exception: code or settings of its digests are later than the result, and the reason states how.

Usage, in the project's folder: ``python docs/long_results.py`` prints the exceptions and what changed. With ``--older
NAME REASON`` result NAME becomes an exception for the code and settings as they are now.
"""

import argparse
import hashlib
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from repro.config.check import load_config
from repro.config.sections import stated
from repro.documents import read_json
from repro.experiments.code import CodeDigests
from repro.experiments.record import config_digest
from repro.files import write_json

ROOT = Path(__file__).resolve().parents[1]
RECORDS = ROOT / "docs/long_results"
#: Most changed definitions that a line names.
SHOWN = 4
ARM = ("signals", "arm", "board", "experiment")
USED = ("signals", "network", "data", "image", "training", "metric", "algorithm1", "refinement")
EXPERIMENTS = "data/experiments/accepted.csv"
#: Modules that check input, print and write: a change refuses or reports something else, and computes the same.
NOT_DECIDING = ("repro.documents:", "repro.errors:", "repro.files:", "repro.progress:", "repro.fingerprint:")


@dataclass(frozen=True)
class LongResult:
    """What is kept of one target or benchmark, and what decides it."""

    kept: str  # pattern of its files
    command: str  # that makes it again
    code: tuple[str, ...] = ()  # definitions or modules, as rules name them
    scripts: tuple[str, ...] = ()
    sections: tuple[str, ...] = ()
    inputs: tuple[str, ...] = ()  # patterns of files of the project that it is computed from
    overlays: tuple[str, ...] = ()  # configuration files besides the default


LONG_RESULTS = {
    "accepted": LongResult(
        "docs/reference/tables/accepted*.csv",
        "snakemake accepted",
        (
            "repro.experiments.accepted:simulate_accepted",
            "repro.experiments.guesses:search_accepted",
            "repro.exhibits.print_compatible:accepted_table",
            "repro.exhibits.print_compatible:accepted_cells",
            "repro.exhibits.print_compatible:guesses",
        ),
        sections=(*USED, *ARM[1:], "networks", "accepted"),
        inputs=(EXPERIMENTS, "data/networks/*.safetensors"),
    ),
    "factorial": LongResult(
        "docs/reference/tables/factorial*.csv",
        "snakemake factorial factorial_cells",
        (
            "repro.experiments.accepted:simulate_accepted",
            "repro_studies.factorial_networks:train_cell",
            "repro_studies.factorial_networks:score_cell",
            "repro_studies.factorial:score_references",
            "repro_studies.exhibits.factorial",
        ),
        sections=(*USED, *ARM[1:], "factorial"),
        inputs=(EXPERIMENTS,),
    ),
    "paper_recipe": LongResult(
        "docs/reference/tables/paper_recipe.csv",
        "snakemake paper_recipe",
        (
            "repro.experiments.training:train_network",
            "repro.experiments.networks:identify_numeric",
            "repro.experiments.networks:identify_experiment",
            "repro.experiments.identifications:score_numeric",
            "repro.experiments.identifications:score_experiment",
        ),
        sections=(*USED, *ARM[1:], "networks", "numeric"),
        inputs=("data/captures/*.bin",),
    ),
    "study": LongResult(
        "docs/reference/study/cells/*.csv",
        "snakemake --configfile config/calibrated.yaml -- study",
        (
            "repro_studies.methods:make_arms",
            "repro_studies.methods:train_reader",
            "repro_studies.methods:run_job",
        ),
        sections=(*USED, *ARM[1:], "study"),
        overlays=("config/calibrated.yaml",),
    ),
    "ablation": LongResult(
        "docs/reference/tables/ablation.csv",
        "snakemake ablation",
        ("repro_studies.ablation:train_variant", "repro_studies.ablation:run_variant"),
        sections=(*USED, *ARM[1:], "networks", "numeric", "ablation"),
        inputs=("data/captures/*.bin",),
    ),
    "match": LongResult(
        "data/experiments/*.csv",
        "snakemake match",
        ("repro.matching.search:fit_start", "repro.matching.search:collect"),
        sections=(*ARM, "matching"),
    ),
    "accepted_networks": LongResult(
        "benchmarks/results/accepted_networks.csv",
        "python benchmarks/accepted_networks.py SEED=RUN ...",
        (
            "repro.experiments.accepted:simulate_accepted",
            "repro.experiments.guesses:search_accepted",
            "repro.experiments.training:train_network",
        ),
        scripts=("benchmarks/accepted_networks.py",),
        sections=(*USED, *ARM[1:], "networks", "accepted"),
        inputs=(EXPERIMENTS,),
    ),
    "networks_spread": LongResult(
        "src/repro/spread.csv",
        "python benchmarks/training_spread.py RUN ...",
        ("repro.cnn.train", "repro.experiments.networks"),
        sections=(*USED, *ARM[1:], "networks", "numeric"),
    ),
    "interval_coverage": LongResult(
        "benchmarks/results/interval_coverage.csv",
        "python benchmarks/interval_coverage.py",
        scripts=("benchmarks/interval_coverage.py", "benchmarks/planar_arms.py"),
    ),
    "board_size": LongResult(
        "data/board/size.csv", "snakemake synthesise_board", ("repro.board.logic:board_size",), inputs=("rtl/*.py",)
    ),
}


def digests(*names: str, root: Path = ROOT) -> dict[str, dict[str, Any]]:
    """Digests of what decides each result: of its code by definition, and of its settings with its input files."""
    code = CodeDigests(*(root / "src" / name for name in ("repro", "repro_studies")))
    found = {}
    for name in names:
        result = LONG_RESULTS[name]
        scripts = [line for script in result.scripts for line in code.of_script(root / script)]
        config = load_config(root / "config/config.yaml", *(root / each for each in result.overlays))
        files = sorted(path for pattern in result.inputs for path in root.glob(pattern))
        inputs = {path.relative_to(root).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}
        found[name] = {
            "code": dict(
                line.rsplit(" ", 1) for line in (*code.of(*result.code), *scripts) if not line.startswith(NOT_DECIDING)
            ),
            "settings_sha256": config_digest({**stated(config, *result.sections), "inputs": inputs}),
        }
    return found


def recorded(name: str) -> dict[str, Any]:
    """Record of a result; empty if it has none."""
    path = RECORDS / f"{name}.json"
    content: dict[str, Any] = read_json(path) if path.exists() else {"code": {}}
    return content


def kept(root: Path = ROOT) -> list[str]:
    """Names of the results that are kept."""
    return [name for name, result in LONG_RESULTS.items() if any(root.glob(result.kept))]


def changes(*names: str, root: Path = ROOT) -> list[str]:
    """One line for code or settings that are no longer the recorded ones, of these results or of all that are kept."""
    lines = []
    for name, found in digests(*(names or kept(root)), root=root).items():
        before, result = recorded(name), LONG_RESULTS[name]
        changed = sorted({definition for definition, _ in found["code"].items() ^ before["code"].items()})
        rest = f", {len(changed) - SHOWN} more" if len(changed) > SHOWN else ""
        what = [f"code changed ({', '.join(changed[:SHOWN])}{rest})"] if changed else []
        what += ["settings changed"] if found["settings_sha256"] != before.get("settings_sha256") else []
        again = f"run {result.command!r} again, or state with --older why the result stands"
        lines += [f"{name} ({result.kept}): {each} since they were recorded: {again}" for each in what]
    return lines


def record(name: str, commit: str | None = None, older: str = "") -> None:
    """Write a result's record for code and settings as they are; without a commit that of the record stays."""
    made = {"commit": commit or recorded(name)["commit"], **digests(name)[name]}
    RECORDS.mkdir(exist_ok=True)
    write_json(RECORDS / f"{name}.json", made | ({"older": older} if older else {}))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--older", nargs=2, metavar=("NAME", "REASON"), help="make a result an exception")
    if chosen := parser.parse_args().older:
        record(chosen[0], older=chosen[1])
    for name in kept():
        print(f"{name}: {recorded(name).get('older', 'as recorded')}")
    problems = changes()
    print("\n".join(problems) or "every long result has the code and settings that are recorded")
    sys.exit(bool(problems))
