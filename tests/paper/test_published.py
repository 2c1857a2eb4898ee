"""The published numbers: complete, as printed, and guarded against damage."""

import re
from collections import Counter
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from experiment_example import refused

import repro
from repro.experiments.code import CodeDigests
from repro.paper.published import KINDS, PUBLISHED_FILE, RELATIONS, load_published

PUBLISHED = load_published()
NAMES = ("I1", "I2", "I3", "g1", "g2", "b1", "b2", "k1", "k2")


def test_every_cell_of_every_table_is_there_once():
    similarity, arms = (("time", "frequency", "total"), (1, 2), ("",)), ("N1", "N2", "N3", "N4")
    tables = {
        "Table 4": (arms[:2], ("true", "algorithm1"), ("parameter",), (None,), NAMES),
        "Table 5": (arms[2:], ("true", "algorithm1"), ("parameter",), (None,), NAMES),
        "Table 7": (arms, ("algorithm1",), *similarity),
        "Table 10": (("ID", "T1", "T2", "T3", "T4"), ("algorithm1", "least-squares"), *similarity),
    }
    for place, cells in tables.items():
        found = Counter((v.case, v.method, v.quantity, v.joint, v.parameter) for v in PUBLISHED if v.place == place)
        assert found == Counter(product(*cells)), place
    # Similarity, two gains and filter coefficient of two joints, one PWM frequency.
    assert sum(v.place == "Table 8" for v in PUBLISHED) == 4 * 2 + 1


def test_the_running_text_is_there_too():
    assert len(PUBLISHED.values) >= 190
    places = {v.place for v in PUBLISHED}
    sections = {"I-A", "II", "III", "IV-A", "IV-B", "IV-C", "V", "V-A", "V-B", "V-C", "VI", "VII"}
    assert places >= {"Abstract", "Appendix A", "Algorithm 1", *(f"Section {s}" for s in sections)}
    assert {v.kind for v in PUBLISHED} == set(KINDS) and {v.relation for v in PUBLISHED} == set(RELATIONS)


@pytest.mark.parametrize(
    ("id_", "value", "half_step", "relation", "kind", "unit"),
    [
        ("abstract/numeric/total", 97.38, 5e-3, "above", "stochastic", "%"),
        ("section7/experimental/total", 93.91, 5e-3, "up to", "hardware-only", "%"),
        ("section5a/loss", 1e-3, 5e-4, "about", "stochastic", "1"),
        ("section4b/iterations", 500_000, 500, "is", "setting", "1"),
        ("section4b/learning-rate-slope", 2e-8, 5e-9, "is", "setting", "1"),
        ("section3/encoder-step", 0.748e-3, 5e-7, "is", "exact", "rad"),
        ("section3/logic-share", 29.94, 5e-3, "is", "exact", "%"),
        ("section3/tip-speed", 2.52, 5e-3, "up to", "setting", "m/s"),
        ("section1a/ref21/woa-ga", 93.83, 5e-3, "is", "other-work", "%"),
        ("table04/N1/algorithm1/I1", 0.7389, 5e-5, "is", "stochastic", "kg m^2"),
        ("table10/ID/algorithm1/total/joint1", 93.55, 5e-3, "is", "hardware-only", "%"),
        ("appendix/energy", 6.2020e-5, 5e-10, "is", "deterministic", "kg^2 m^4/s^2"),
        ("table05/N3/algorithm1/b1", 0.1200, 5e-5, "is", "stochastic", "kg m^2 s"),
    ],
)
def test_values_and_how_finely_they_are_known(id_, value, half_step, relation, kind, unit):
    v = PUBLISHED[id_]
    assert v.value == pytest.approx(value, rel=1e-12) and v.half_step == pytest.approx(half_step, rel=1e-9)
    assert (v.relation, v.kind, v.unit) == (relation, kind, unit)


def test_lookups_agree_with_the_rows():
    true, similarity = PUBLISHED.parameter_sets("true"), PUBLISHED.similarities("total")
    assert true.shape == (4, 9) and similarity.shape == (4, 2)
    np.testing.assert_array_equal(true[2], [0.5020, 0.9779, 0.5040, 0.4777, 0.5724, 0.0715, 0.3820, 0.0972, 0.5721])
    np.testing.assert_allclose(similarity[1], [0.9498, 0.9904])


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("id,place,", "name,place,", "header"),
        (",0.6590,", ",nan,", "line {0}: value"),
        (",0.6590,,setting\n", "\n", "line {0}"),
        (",0.6590,,setting", ",0.6590,,guess", "line {0}: kind"),
        ("I1,kg m^2,is,0.6590", "I1,kg m^2,near,0.6590", "line {0}: relation"),
        (",1,,%,is,99.77", ",3,,%,is,99.77", "joint"),
        ("table04/N1/true/I2,", "table04/N1/true/I1,", "line {1}: id"),
    ],
)
def test_a_damaged_file_is_refused_in_one_line(tmp_path, old, new, expected):
    text = PUBLISHED_FILE.read_text()
    assert old in text
    line = next(n for n, row in enumerate(text.splitlines(), start=1) if row.startswith("table04/N1/true/I1,"))
    path = tmp_path / "published.csv"
    path.write_text(text.replace(old, new, 1))
    assert re.match(rf"{path}.*{expected.format(line, line + 1)}.*found .*expected", str(refused(load_published, path)))


@pytest.mark.slow
def test_nothing_that_makes_results_reads_the_published_numbers():
    code, workflow = CodeDigests(), Path(repro.__file__).parents[2] / "workflow"
    rules = "".join(file.read_text(encoding="utf-8") for file in workflow.glob("rules/*.smk"))
    computing = set(re.findall(r'"((?:repro\.experiments|repro_studies)[\w.]*:\w+)"', rules))
    assert len(computing) > 10
    for function in computing:
        reached = code.of_script(workflow / "scripts/call.py", function)
        assert not [name for name in reached if name.startswith("repro.paper")], function
    for family in ("numeric_tests", "arm_experiment", "many_arms", "causes", "time_factors"):
        assert not [name for name in code.of(f"repro.exhibits.{family}") if name.startswith("repro.paper")], family
