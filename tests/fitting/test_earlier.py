"""A result is compared with an earlier one: a change that the intervals do not explain is named."""

import json

import numpy as np
import pytest
from experiment_example import refused
from log_example import BETA, motion
from regression_example import log_from, with_noise

import repro
from repro.fitting.earlier import changes_since


def identified(beta, seed, **options):
    log = with_noise(log_from(motion, seconds=20.0, beta=beta), 0.03, seed)
    return repro.identify(log, arm=repro.Arm(delay=0.0), **options)


@pytest.fixture(scope="module")
def earlier(tmp_path_factory):
    folder = tmp_path_factory.mktemp("earlier") / "out"
    identified(BETA, 1).save(folder)
    return folder / "parameters.json"


def test_the_same_arm_agrees_and_a_heavier_link_does_not(earlier):
    same = identified(BETA, 2, earlier=earlier).details.changes
    assert [change.name for change in same] == ["I1", "I2", "I3", "g1", "g2", "b1", "b2", "k1", "k2"]
    assert all(change.agree for change in same)
    assert np.array([change.before for change in same]) == pytest.approx(BETA, rel=0.1)
    heavier = BETA * np.where(np.arange(9) == 4, 1.1, 1.0)
    changed = {c.name: c for c in identified(heavier, 3, earlier=earlier).details.changes}
    assert changed["g2"].agree is False and changed["g1"].agree
    assert changed["g2"].now / changed["g2"].before == pytest.approx(1.1, rel=0.01)


@pytest.mark.parametrize(("share", "agree"), [(0.9, True), (1.1, False)])
def test_a_change_may_be_as_large_as_the_root_of_the_sum_of_squares_of_the_half_widths(earlier, tmp_path, share, agree):
    content, result = json.loads(earlier.read_text()), identified(BETA, 2).details
    for before, now in zip(content["methods"][0]["parameters"], result.best.parameters, strict=True):
        halves = 0.5 * np.array([before["high"] - before["low"], now.high - now.low])
        before["estimate"] = now.estimate - share * np.linalg.norm(halves)
    (tmp_path / "moved.json").write_text(json.dumps(content))
    assert [change.agree for change in changes_since(tmp_path / "moved.json", result)] == [agree] * 9


def test_a_method_without_intervals_or_a_parameter_at_its_bound_is_not_judged(earlier):
    frictionless = identified(BETA * np.where(np.arange(9) == 5, 0.0, 1.0), 4, earlier=earlier, method="bounded")
    judged = {change.name: change.agree for change in frictionless.details.changes}
    assert judged["b1"] in {None, False} and judged["g1"]


def test_what_is_no_result_is_refused(tmp_path):
    file = tmp_path / "parameters.json"
    file.write_text("{}")
    assert refused(identified, BETA, 5, earlier=file).place == str(file)
