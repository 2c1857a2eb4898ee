"""Every kept number that needs no network is what the code makes of the captures and of what networks made.

Kept of networks are their estimates and the scores of arms that were simulated again. Least squares is computed here.
"""

import re
from itertools import product

import pytest
from experiment_example import ROOT

from repro.comparison import Kind, Tolerances, differences
from repro.config.check import load_config
from repro.exhibits.catalogue import EXHIBITS
from repro.exhibits.declare import show
from repro.experiments.identifications import (
    identify_least_squares,
    least_squares_of_arms,
    score_experiment,
    score_numeric,
)
from repro.files import read_rows, write_csv, write_json
from repro.signals.programs import PROGRAMS
from repro_studies.factorial import CELLS

REFERENCE = ROOT / "docs/reference"
CONFIG = load_config(ROOT / "config/config.yaml")
#: Nothing is simulated or trained here, so that all numbers are compared as computed ones.
STRICT = Tolerances(reproducible=frozenset(Kind))


def captures(*motions):
    return [ROOT / f"data/captures/{motion}.{end}" for motion, end in product(motions, ("bin", "program", "json"))]


def estimates(of, seeds, *networks):
    """Kept estimates by networks, in the order of the workflow."""
    names = [f"{of}{network}-seed{seed}" for network, seed in product(networks, seeds)]
    return [REFERENCE / f"identification/{name}.json" for name in names]


def by_number(pattern):
    return sorted(REFERENCE.glob(pattern), key=lambda path: int(re.sub(r"\D", "", path.stem)))


PUBLISHED, TRACKED = (estimates("numeric", CONFIG.numeric.seeds, network) for network in ("", "-tracked"))
ARM = estimates("experiment", CONFIG.experiment.search_seeds, "", "-tracked", "-desired", "-tracked-measured")
FACTORIAL = [f"{cell}-seed{seed}-search1" for cell, seed in product(CELLS, CONFIG.factorial.training_seeds)]
#: Files that exhibits are computed from, by the keys of `SOURCES` in workflow/rules/exhibits.smk.
SOURCES = {
    "diagrams": {"diagrams": sorted((ROOT / "src/repro/exhibits/diagrams").iterdir())},
    "board": {"synthesis": [ROOT / "data/board/size.csv"]},
    "ID": {"captures": captures("ID")},
    "networks": {
        "identifications": [*PUBLISHED, *TRACKED],
        "scores": [REFERENCE / f"validation/numeric{suffix}.csv" for suffix in ("", "-tracked")],
    },
    "arm": {"identifications": ARM, "scores": [REFERENCE / "validation/experiment.csv"]},
    "headline": {"captures": captures(*PROGRAMS), "arm": ARM, "numeric": [*PUBLISHED, *TRACKED]},
    "spread": {"scores": [REFERENCE / "accepted/methods.csv"]},
    "factorial": {
        "scores": [REFERENCE / f"factorial/{name}.csv" for name in FACTORIAL],
        "references": [REFERENCE / "factorial/references.csv"],
    },
    "accepted": {"scores": by_number("accepted/experiment-*.csv")},
    "matching": {
        "starts": [ROOT / "data/experiments/starts.csv"],
        "experiments": [ROOT / "data/experiments/accepted.csv"],
    },
}
#: Which of these have least squares last.
WITH_LEAST_SQUARES = {
    ("networks", "identifications"): "numeric",
    ("arm", "identifications"): "arm",
    ("headline", "arm"): "arm",
    ("headline", "numeric"): "numeric",
}
#: Exhibits that are not computed again here, and why.
ELSEWHERE = {
    "study": "tests/studies/test_kept_study.py",
    "coverage": "needs the network",
    "search": "takes 80 s: the golden run has it",
    "paper_recipe": "its scores are not kept (docs/long_results)",
    "losses": "its histories are not kept (docs/long_results)",
}
KEPT = {exhibit.target: exhibit for exhibit in EXHIBITS if (REFERENCE / f"{exhibit.kind}s/{exhibit.name}.csv").exists()}
AGAIN = [name for name, exhibit in KEPT.items() if not ELSEWHERE.keys() & set(exhibit.inputs)]


@pytest.fixture(scope="module")
def least_squares(tmp_path_factory):
    """Files of estimates by least squares, computed here."""
    folder = tmp_path_factory.mktemp("least_squares")
    write_json(folder / "numeric.json", least_squares_of_arms(CONFIG))
    write_json(folder / "arm.json", identify_least_squares(captures("ID"), CONFIG))
    return {name: folder / f"{name}.json" for name in ("numeric", "arm")}


def assert_same(frame, kept, tmp_path):
    write_csv(tmp_path / "made.csv", frame)
    found = differences(kept.stem, read_rows(kept), read_rows(tmp_path / "made.csv"), STRICT)
    assert not [f"{kept.name}: {each.place}: kept {each.a}, made {each.b}" for each in found if each.broken]


def test_every_kept_table_is_of_an_exhibit_and_every_exhibit_has_its_sources():
    kept = {path.stem for path in (REFERENCE / "tables").glob("*.csv")}
    assert kept == {exhibit.name for exhibit in KEPT.values() if exhibit.kind == "table"}
    always = {exhibit.name for exhibit in EXHIBITS if exhibit.kind == "table" and not exhibit.optional}
    assert always <= kept
    assert {name for exhibit in KEPT.values() for name in exhibit.inputs} <= SOURCES.keys() | ELSEWHERE.keys()


@pytest.mark.parametrize("name", AGAIN)
def test_numbers_of_an_exhibit_follow_from_what_is_kept(name, least_squares, tmp_path):
    exhibit, inputs = KEPT[name], {}
    for source, key in ((each, key) for each in exhibit.inputs for key in SOURCES[each]):
        further = WITH_LEAST_SQUARES.get((source, key))
        inputs[key] = [*SOURCES[source][key], *([least_squares[further]] if further else [])]
    assert_same(exhibit.numbers(inputs, CONFIG), REFERENCE / f"{exhibit.kind}s/{exhibit.name}.csv", tmp_path)


@pytest.mark.parametrize("name", [name for name, exhibit in KEPT.items() if exhibit.kind == "table"])
def test_a_table_is_laid_out_as_its_numbers_are(name, tmp_path):
    exhibit = KEPT[name]
    kept = {end: REFERENCE / f"tables/{exhibit.name}.{end}" for end in ("csv", "tex", "md")}
    made = {end: tmp_path / path.name for end, path in kept.items()}
    made["csv"].write_bytes(kept["csv"].read_bytes())
    show(exhibit, made)
    assert [made[end].read_text(encoding="utf-8") for end in ("tex", "md")] == [
        kept[end].read_text(encoding="utf-8") for end in ("tex", "md")
    ]


def test_kept_scores_follow_from_the_estimates(least_squares, tmp_path):
    made = {
        "numeric": score_numeric([*PUBLISHED, least_squares["numeric"]], CONFIG),
        "numeric-tracked": score_numeric(TRACKED, CONFIG),
        "experiment": score_experiment([*ARM, least_squares["arm"]], captures(*PROGRAMS), CONFIG),
    }
    for name, scores in made.items():
        assert_same(scores, REFERENCE / f"validation/{name}.csv", tmp_path)
