"""The measured length of link 1 narrows the fit, unless the log contradicts it."""

from dataclasses import replace

import numpy as np
import pytest
from fitting_problem import loaded, problem_of_logs
from log_example import BETA, motion
from regression_example import log_from, with_noise

from repro.identification.armfile import Arm
from repro.identification.least_squares import METHODS
from repro.identification.uncertainty import bootstrap

GRAVITY = 9.80665
LENGTH = BETA[1] * GRAVITY / (2.0 * BETA[4])  # of link 1, which the known arm implies
LOG = with_noise(log_from(motion, seconds=20.0), 0.2, 4)


def problem(log=LOG, **arm):
    return problem_of_logs(loaded(log), arm=Arm(delay=0.0, **arm))


@pytest.mark.parametrize("name", ["ordinary", "robust", "weighted-consistent"])
def test_a_known_length_narrows_i2_and_its_interval_contains_the_truth(name):
    method, widths = METHODS[name], {}
    for given in ({}, {"link_lengths": (LENGTH, 0.2)}):
        of = problem(**given)
        estimate = method.estimate(of.without_standstill)
        spread = bootstrap(method, of.without_standstill, estimate, of.perturbations, np.random.default_rng(2), 60)
        assert spread.low[1] <= BETA[1] <= spread.high[1]
        widths[bool(given)] = spread.high[1] - spread.low[1]
        implied = estimate.beta[1] * GRAVITY / (2.0 * estimate.beta[4])
    assert implied == pytest.approx(LENGTH, abs=1e-3)  # the standard deviation of a ruler
    assert widths[True] < 0.8 * widths[False]


def test_a_length_that_is_known_badly_changes_little():
    free = METHODS["ordinary"].estimate(problem().without_standstill).beta
    vague = problem(link_lengths=(1.3 * LENGTH, 0.2), link_length_sd=100.0 * LENGTH).without_standstill
    assert METHODS["ordinary"].estimate(vague).beta == pytest.approx(free, rel=1e-3)


def test_times_that_are_twice_the_true_ones_contradict_the_length():
    slow = replace(LOG, t=2.0 * LOG.t)
    of = problem(slow, link_lengths=(LENGTH, 0.2))
    assert of.prior is None and of.length.relation is None
    assert of.length.implied == pytest.approx(4.0 * LENGTH, rel=0.1)  # inertia is four times, gravity the same


def test_in_a_horizontal_plane_gravity_shows_no_length():
    of = problem(link_lengths=(LENGTH, 0.2), plane="horizontal")
    assert of.length is None and not of.prior.relations
