"""Which method `repro identify` recommends, why, and what it warns of."""

from dataclasses import replace

import numpy as np
import pytest
from fitting_example import method, score
from fitting_problem import problem_of
from regression_example import exciting

from repro.fitting.link_length import LinkLength
from repro.fitting.prior import read_prior
from repro.fitting.recommend import (
    compare_networks,
    contradicted,
    recommend,
    undriven,
    unusable,
    warnings,
    wrong_length,
)
from repro.fitting.result import Excitation
from repro.identification.regression import Relation
from repro.model.parameters import NAMES


def test_validation_logs_count_before_halves():
    # Halves say b, the logs not used say a; without such logs it is b.
    a = method("a", "A", 1.0, halves=(score("second half", 0.5, 0.5),))
    b = method("b", "B", 1.1, halves=(score("second half", 0.01, 0.01),))
    assert recommend((a, b))[0] == recommend((b, a))[0] == "a"
    assert recommend([replace(m, validation=()) for m in (a, b)])[0] == "b"
    assert recommend([replace(m, validation=(), halves=m.validation) for m in (a, b)])[0] == "a"


def test_halves_make_parameters_unusable_only_without_validation_logs():
    a = method("a", "A", 1.0, validation=(score("x", 0.1, 0.2),), halves=(score("second half", 0.1, 0.6),))
    assert not unusable(a)
    half = unusable(replace(a, validation=()))
    assert "60 %" in half and "(second half)" in half
    bad = replace(a, validation=(score("x", 0.51, 0.2),))
    assert "51 %" in unusable(bad) and "(x)" in unusable(bad)


SCORES = {"fit": score("log.csv", 0.05, 0.06), "validation": (score("x", 0.05, 0.119), score("y", 0.119, 0.1))}
GOOD = method("a", "A", **SCORES, halves=(score("second half", 0.05, 0.119),), whiteness=(0.5, -0.5))
KNOWN = tuple(replace(p, low=0.9 * p.estimate, high=1.1 * p.estimate) for p in GOOD.parameters)
VAGUE = tuple(replace(p, low=None, high=None) for p in GOOD.parameters)
TELLING = Excitation(9, 100.0, (0.1,) * 9, (-0.9, 0.9), (), NAMES)
#: Each limit just passed: what is changed, and words of the one warning about it.
PASSED = [
    ({"rank": 7, "condition": 1e16}, {}, {}, ("7",)),
    ({"condition": 100.1}, {}, {}, ("100",)),
    ({"friction_correlation": (-0.901, 0.9)}, {"parameters": VAGUE}, {}, ("joint 1", "-0.90")),
    ({"friction_correlation": (-0.9, 0.95)}, {"parameters": VAGUE}, {}, ("joint 2", "0.95")),
    ({"friction_correlation": (0.92, 0.92)}, {"parameters": (*KNOWN[:7], VAGUE[7], KNOWN[8])}, {}, ("joint 1", "0.92")),
    ({}, {"fit": score("log.csv", 0.251, 0.06)}, {}, ("25.1 %", "joint 1")),
    ({}, {"fit": score("log.csv", 0.05, 0.42)}, {}, ("42 %", "joint 2")),
    ({}, {"whiteness": (0.51, 0.1)}, {}, ("0.51",)),
    ({}, {"whiteness": (0.1, -0.7)}, {}, ("-0.70",)),
    ({}, {"validation": (score("x", 0.05, 0.121),)}, {}, ("12.1 %", "6 %")),
    ({}, {"halves": (score("second half", 0.05, 0.121),)}, {}, ("12 %",)),
    ({}, {}, {"delay": 0.02}, ("delay", "(20 ms)")),
    ({}, {}, {"delay": 0.0197}, ("2 sampling periods", "19.7 ms are applied")),
    ({}, {}, {"delay": 0.01}, ("2 sampling periods", "only 10 ms are applied")),
    ({}, {}, {"delay": -0.02}, ("delay", "(-20 ms)")),
    ({}, {}, {"delay": -0.0051}, ("delay", "-5.1 ms")),
    ({}, {"consistent": False, "why_not_consistent": "b2 = -1"}, {}, ("b2 = -1",)),
]


def warned(excitation, changes, settings, others=()):
    problem = problem_of(exciting(50), **{"delay": 0.0, **settings})
    return warnings(problem, (*others, replace(GOOD, **changes)), "a", replace(TELLING, **excitation))


def test_at_its_limits_nothing_is_warned_of():
    assert warned({}, {}, {}) == ()
    assert warned({}, {"fit": score("log.csv", 0.25, 0.25)}, {}) == ()
    assert warned({}, {"validation": ()}, {"delay": -0.0049}) == ()
    assert warned({}, {}, {"delay": 0.02, "estimates_delay": False}) == ()
    # A tenth is little, however small the error on the log itself.
    for error, count in ((0.1, 0), (0.101, 2)):
        unseen = {"validation": (score("x", error, 0.1),), "halves": (score("first half", 0.1, error),)}
        assert len(warned({}, {"fit": score("log.csv", 0.01, 0.01), **unseen}, {})) == count
    # What another method does is not reported.
    bad = method("b", "B", whiteness=(0.99, 0.99), consistent=False, fit=score("log.csv", 0.9, 0.9))
    assert warned({}, {}, {}, (bad,)) == ()


@pytest.mark.parametrize(("excitation", "changes", "settings", "words"), PASSED)
def test_each_limit_passed_gives_one_warning(excitation, changes, settings, words):
    (line,) = warned(excitation, changes, settings)
    assert all(word in line for word in words), line


def test_a_short_log_is_warned_of():
    problem = problem_of(exciting(50), delay=0.0)
    loaded = problem.first.loaded
    gap = 20.0 * (loaded.log.t > 9.0)
    for seconds, short in ((14.9, True), (15.1, False)):
        log = replace(loaded.log, t=np.linspace(0.0, seconds, gap.size) + gap, breaks=(int(gap.argmax()),))
        ready = replace(problem.first, loaded=replace(loaded, log=log))
        assert len(warnings(replace(problem, logs=(ready,)), (GOOD,), "a", TELLING)) == short


@pytest.mark.parametrize(
    ("over_rest", "unknown", "lines"), [(5.1, (0, 2), 0), (4.9, (0, 2), 1), (4.9, (1,), 0), (4.9, (3, 4), 0)]
)
def test_a_motion_too_slow_for_inertia_is_warned_of(over_rest, unknown, lines):
    """Only if the intervals of two of I1 to I3 are wide, and the unexplained torque of a joint is the reason."""
    problem = problem_of(exciting(50), delay=0.0)
    r = problem.without_standstill
    beta = np.array([p.estimate for p in GOOD.parameters])
    inertia = r.y[..., :3] @ beta[:3]
    rest = np.array([[1e-3], [np.sqrt(np.mean(inertia[1] ** 2)) / over_rest]]) * np.ones(r.t.size)
    wide = [replace(p, low=-p.estimate, high=3.0 * p.estimate) if k in unknown else p for k, p in enumerate(KNOWN)]
    found = warnings(
        replace(problem, without_standstill=replace(r, tau=r.y @ beta + rest)),
        (replace(GOOD, parameters=tuple(wide)),), "a", replace(TELLING, friction_correlation=(0.0, 0.0)),
    )  # fmt: skip
    assert sum("inertia" in line for line in found) == len(found) == lines


@pytest.mark.parametrize(("share", "lines"), [(0.9, 0), (1.1, 1)])
def test_a_prior_outside_the_interval_is_contradicted(share, lines):
    g1 = GOOD.parameters[3]
    prior = read_prior({"g1": {"value": g1.estimate + share * (g1.high - g1.estimate), "sd": 1e-3}})
    found = list(contradicted(replace(problem_of(exciting(50), delay=0.0), prior=prior), GOOD))
    assert len(found) == lines and all("g1" in line for line in found)


def test_a_joint_without_torque_is_named():
    r = exciting(50)
    for joint in (1, 2):
        weak, still = (r.tau * np.where(np.arange(2) == joint - 1, x, 1.0)[:, np.newaxis] for x in (0.1, 0.0))
        assert not list(undriven(problem_of(replace(r, tau=weak)), GOOD))
        (line,) = undriven(problem_of(replace(r, tau=still)), GOOD)
        assert line.startswith(f"joint {joint} ") and "log.csv" in line


def test_without_a_prediction_the_fit_decides():
    a, b, c = (
        method(name, name, fit=score("log.csv", *fit), validation=(), halves=(), consistent=consistent)
        for name, fit, consistent in (("a", (0.2, 0.1), True), ("b", (0.05, 0.12), True), ("c", (0.01, 0.01), False))
    )
    for methods in ((a, b, c), (c, b, a)):
        assert recommend(methods)[0] == "b"
    # Where one was judged on halves, what it predicts counts before the fit.
    assert recommend((b, replace(a, halves=(score("second half", 0.9, 0.9),))))[0] == "a"


@pytest.mark.parametrize("part", ["validation", "halves", "fit"])
def test_of_errors_within_a_percent_the_first_asked_for_is_taken(part):
    def with_error(name, error):
        only = {"validation": (), "halves": (), "fit": score("log.csv", 0.5, 0.5)}
        one = score("x", error, error)
        return method(name, name, **{**only, part: one if part == "fit" else (one,)})

    best, as_good, worse = with_error("best", 0.1), with_error("as good", 0.1009), with_error("worse", 0.1011)
    assert recommend((worse, as_good, best))[0] == "as good"
    assert recommend((best, as_good, worse))[0] == "best"
    assert recommend((worse, best))[0] == "best"
    assert recommend((worse, replace(best, claims_intervals=False)))[0] == "worse"


def network(error, similarity=0.9, name="algorithm1", **changes):
    """A method with this validation error in both joints, and this similarity on the log itself."""
    fit = replace(score("log.csv", 0.1, 0.1), similarity=(similarity - 0.01, similarity + 0.01))
    return method(name, name, fit=fit, **{"validation": (score("x", error, error),), "notes": ("first",), **changes})


def note(*methods):
    """What is added to the first of the methods, the only one that runs a network."""
    compared = compare_networks(methods, ("algorithm1",))
    first, added = compared[0].notes
    assert compared == (replace(methods[0], notes=(first, added)), *methods[1:])
    return added


@pytest.mark.parametrize(
    ("similarity", "words"), [(0.95, "5 points higher"), (0.897, "0.3 points lower"), (0.85, "5 points lower")]
)
def test_the_note_on_a_network_that_predicts_far_worse_gives_the_reason(similarity, words):
    added = note(network(0.15, similarity), network(0.3, name="b"), network(0.1, name="a"))
    assert "1.5 times" in added and "(a)" in added and words in added
    # Up to a twentieth worse needs no reason.
    assert ";" not in note(network(0.1049, similarity), network(0.1, name="a"))
    assert ";" in note(network(0.1051, similarity), network(0.1, name="a"))


def test_a_network_is_compared_with_least_squares_only_on_logs_that_both_predicted():
    one, other = network(0.1), network(0.2, name="a")
    unseen = [replace(m, validation=()) for m in (one, other)]
    for methods in ((one,), (one, unseen[1]), (unseen[0], other), (other, network(0.1, name="b"))):
        assert compare_networks(methods, ("algorithm1",)) == methods


@pytest.mark.parametrize(("implied", "factor"), [(2.0, "2 times"), (0.125, "0.5 times"), (-0.3, "")])
def test_a_length_that_the_logs_contradict_is_named(implied, factor):
    (line,) = wrong_length(LinkLength(0.5, implied, None))
    assert "0.5 m" in line and f"{implied:g} m" in line and factor in line
    assert ("times the true ones" in line) == bool(factor)


def test_a_length_that_is_in_the_fit_needs_no_warning():
    assert not [*wrong_length(None), *wrong_length(LinkLength(0.5, 0.7, Relation(np.ones(9), 0.1)))]


def positioned(name, torque, position):
    return method(name, name, 1.0, validation=(replace(score("x", torque, torque), position_rms=(position, position)),))


def test_torque_and_position_count_by_their_product():
    methods = positioned("a", 0.10, 0.30), positioned("b", 0.12, 0.20), positioned("c", 0.30, 0.19)
    name, reason = recommend(methods)
    assert name == "b"
    assert "a has the smaller torque error, 10 instead of 12 %" in reason
    assert "c has the smaller position error, 0.19 instead of 0.2 rad" in reason
    name, reason = recommend(methods[:1] + methods[2:])
    assert name == "a" and "c has the smaller position error" in reason and "smaller torque error" not in reason
    unstable = replace(methods[1], validation=(replace(methods[1].validation[0], position_rms=None),))
    assert recommend((unstable, methods[2]))[0] == "c"
    assert recommend((unstable,))[0] == "b"
