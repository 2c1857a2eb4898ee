"""Verdicts on parameters, and calibration errors as lines of the arm file."""

import re
from types import SimpleNamespace

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from repro.fitting import text
from repro.fitting.text import (
    AT_BOUND,
    COMBINED,
    NO_INTERVAL,
    NOT_EXCITED,
    NOT_FROM_ZERO,
    SIGN_KNOWN,
    known_to,
    verdict,
)
from repro.identification.armfile import Arm, read_arm
from repro.identification.calibration import CalibrationError, correct_calibration
from repro.identification.log import Log
from repro.logs.load import to_eq1

ERRORS = (
    CalibrationError("zero1", 0.05, 0.002, 0.09, 0.05),
    CalibrationError("zero2", -0.1, 0.002, 0.09, 0.05),
    CalibrationError("offset1", 0.2, 0.01, 0.08, 0.05),
    CalibrationError("scale2", 1.5, 0.01, 0.08, 0.05),
)


def verdict_within(share, estimate=2.0, excited=True):
    reach = share * abs(estimate)
    return verdict(estimate, estimate - reach, estimate + reach, excited, at_bound=False)


@pytest.mark.parametrize("estimate", [2.0, -1e-6])
def test_verdicts_at_their_limits(estimate):
    for share, percent in ((0.004, "0.4"), (0.00401, "0.5"), (0.01, "1"), (0.0101, "2"), (0.4999, "50")):
        assert verdict_within(share, estimate) == known_to(percent)
    assert verdict_within(0.51, estimate) == verdict_within(0.99, estimate) == SIGN_KNOWN
    assert verdict_within(1.01, estimate) == verdict_within(30.0, estimate) == NOT_FROM_ZERO


@pytest.mark.parametrize("excited", [False, True])
def test_verdicts_depend_on_excitation_only_where_nothing_is_known(excited):
    unknown = verdict(2.0, None, None, excited, at_bound=False), verdict_within(1.1, 2.0, excited)
    words = (NO_INTERVAL, NOT_FROM_ZERO)
    assert unknown == (words if excited else (NOT_EXCITED, NOT_EXCITED))
    for low, high, at_bound in ((1.99, 2.01, False), (None, None, True), (-1.0, 5.0, False)):
        combined = verdict(2.0, low, high, excited, at_bound, determined=False)
        assert combined == (COMBINED if excited else NOT_EXCITED)
    assert verdict_within(0.03, 1e-7, excited) == known_to("3")
    assert verdict(0.0, None, None, excited, at_bound=True) == AT_BOUND


@given(st.floats(0.0, 0.4999), st.floats(1e-9, 1e9))
def test_percents_are_never_optimistic_and_at_most_a_digit_too_large(share, estimate):
    printed = float(re.search(r"[0-9.]+", verdict_within(share, estimate))[0])
    actual = 50.0 * ((estimate + share * estimate) - (estimate - share * estimate)) / estimate
    assert printed >= actual - 1e-7
    assert printed <= max(actual + (1.0 if printed > 1.0 else 0.1), 0.1) + 1e-7


@pytest.mark.parametrize("absolute", [False, True])
@pytest.mark.parametrize("sign", [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0)])
def test_the_lines_of_the_arm_file_correct_a_log(tmp_path, absolute, sign):
    rng = np.random.default_rng(0)
    raw = Log(name="log.csv", t=np.arange(50) / 100, q=0.3 * rng.normal(size=(2, 50)), tau=rng.normal(size=(2, 50)))
    keys = {"zero": [0.1, -0.2], "sign": list(sign), "torque_sign": [-1, 1], "torque_scale": [1.2, 0.8]}
    keys["second_joint_absolute"] = absolute
    file = tmp_path / "arm.yaml"

    def read(more):
        file.write_text(yaml.safe_dump(keys | more))
        return read_arm(file), to_eq1(raw, read_arm(file))

    arm, wrong = read({})
    lines = yaml.safe_load(text.arm_lines(ERRORS, arm).replace("; ", "\n"))
    assert set(lines) == {"zero", "torque_offset", "torque_scale"}
    zero, _, offset, *_ = text.calibration_lines(ERRORS, arm, False)  # have the signs of these lines
    assert f" {np.degrees(lines['zero'][0] - 0.1):.2g} +-" in zero and f" {lines['torque_offset'][0]:.3g} +-" in offset
    expected = correct_calibration(wrong, {error.name: error.value for error in ERRORS})
    _, right = read(lines)
    np.testing.assert_allclose(right.q, expected.q, atol=2e-4)  # four digits are printed
    np.testing.assert_allclose(right.tau, expected.tau, atol=2e-3)


@pytest.mark.parametrize(("second", "apart"), [(0.052, False), (-0.05, True), (None, True)])
def test_logs_whose_errors_no_single_arm_file_corrects_are_reported(second, apart):
    def log(zero):
        errors = () if zero is None else (CalibrationError("zero1", zero, 0.002, 0.09, 0.05),)
        loaded = SimpleNamespace(name="a.csv", description=SimpleNamespace(warnings=()))
        return SimpleNamespace(loaded=loaded, calibration_errors=errors, terms=())

    assert (text.DIFFERENT_ERRORS in text.calibration_warnings([log(0.05), log(second)], Arm(), False)) == apart


def test_a_log_that_reads_better_otherwise_gets_no_lines_for_the_arm_file():
    keys = ("zero:", "torque_offset:", "torque_scale:")
    assert all(key in text.calibration_lines(ERRORS, Arm(), True)[-2] for key in keys)
    lines = text.calibration_lines(ERRORS, Arm(), True, misread=True)
    assert len(lines) == len(ERRORS) + 1
    assert not any(key in line for key in keys for line in lines)


@pytest.mark.parametrize(("degrees", "words"), [(1.0, "1 degree"), (1.1, "1.1 degrees"), (0.055, "0.055 degrees")])
def test_one_degree_is_singular(degrees, words):
    log, limits = SimpleNamespace(name="a.csv"), {"zero1": np.radians(degrees)}
    (line,) = text.detection_limits(SimpleNamespace(fitted_logs=(log,), calibration_limits=(limits,), more_logs=()))
    assert line.endswith(f"zero of joint 1 up to {words}")
