"""What is said of a fault of the set-up, and that the lines for the arm file put the log right."""

from types import SimpleNamespace

import numpy as np
import pytest
import yaml

from repro.identification.setup import Fault, corrected
from repro.logs.armfile import Arm, read_arm
from repro.logs.load import to_eq1
from repro.logs.log import Log
from repro.ownarm.text import DIFFERENT_ERRORS, arm_lines, calibration_lines, calibration_warnings, detection_limits

FAULTS = (
    Fault("zero1", 0.05, 0.002, 0.09, 0.05),
    Fault("zero2", -0.1, 0.002, 0.09, 0.05),
    Fault("offset1", 0.2, 0.01, 0.08, 0.05),
    Fault("scale2", 1.5, 0.01, 0.08, 0.05),
)


@pytest.mark.parametrize("absolute", [False, True])
@pytest.mark.parametrize("sign", [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0)])
def test_the_lines_of_the_arm_file_put_a_log_right(tmp_path, absolute, sign):
    rng = np.random.default_rng(0)
    raw = Log("log.csv", np.arange(50) / 100, 0.3 * rng.normal(size=(2, 50)), rng.normal(size=(2, 50)))
    common = {"sign": list(sign), "torque_sign": [-1, 1], "second_joint_absolute": absolute, "zero": [0.1, -0.2]}
    file = tmp_path / "arm.yaml"

    def read(keys):
        file.write_text(yaml.safe_dump(keys))
        return to_eq1(raw, read_arm(file))

    as_it_is = read(common)
    arm = Arm(zero=(0.1, -0.2), sign=sign, torque_sign=(-1.0, 1.0), second_joint_absolute=absolute)
    lines = yaml.safe_load(arm_lines(FAULTS, arm).replace("; ", "\n"))
    assert set(lines) == {"zero", "torque_offset", "torque_scale"}
    right, expected = read(common | lines), corrected(as_it_is, {fault.name: fault.value for fault in FAULTS})
    np.testing.assert_allclose(right.q, expected.q, atol=2e-4)  # four digits are printed
    np.testing.assert_allclose(right.tau, expected.tau, atol=2e-3)


def test_each_fault_is_said_with_its_size_and_what_it_brings():
    lines = calibration_lines(FAULTS, Arm())
    assert lines[0] == (
        "the zero of joint 1 is -2.9 +- 0.23 degrees off; the correction reduces the torque error from 9.0 to 5.0 %"
    )
    assert "offset of 0.2 +- 0.02 N m" in lines[2]
    assert "1.5 +- 0.02 times" in lines[3]
    assert "zero: [-0.05, 0.1]; torque_offset: [0.2, 0]; torque_scale: [1, 1.5]" in lines[-1]
    assert calibration_lines((), Arm()) == ()


@pytest.mark.parametrize(("second", "apart"), [(0.052, False), (-0.05, True), (None, True)])
def test_logs_whose_faults_one_arm_file_cannot_put_right_are_told_of(second, apart):
    def log(zero):
        faults = () if zero is None else (Fault("zero1", zero, 0.002, 0.09, 0.05),)
        return SimpleNamespace(loaded=SimpleNamespace(name="a.csv"), faults=faults, terms=())

    assert (DIFFERENT_ERRORS in calibration_warnings([log(0.05), log(second)], Arm())) == apart
    assert DIFFERENT_ERRORS not in calibration_warnings([log(0.05)], Arm())


def test_a_fault_that_may_be_another_is_said_with_it():
    (line, _) = calibration_lines(
        (Fault("zero2", -0.1, 0.002, 0.09, 0.05, {"zero1": 0.05, "offset1": 0.2, "scale2": 1.4}),), Arm()
    )
    assert line.startswith(
        "the zero of joint 2 is 5.7 +- 0.23 degrees off (this log can hardly distinguish it from the zero of joint 1: "
        "-2.9 degrees, or the offset of the torque of joint 1: 0.2 N m, or the scale of the torque of joint 2: 1.4 "
        "times); the correction"
    )


def test_what_a_log_would_not_show_is_said_in_units_or_as_any_size():
    hidden = {"zero1": np.radians(2.5), "zero2": None, "offset1": 0.035, "scale2": 0.38}
    said = (
        "zero of joint 1 up to 2.5 degrees, zero of joint 2 of any size, "
        "offset of the torque of joint 1 up to 0.035 N m, scale of the torque of joint 2 up to 38 %"
    )
    first, *more = (SimpleNamespace(name=name) for name in ("a.csv", "b.csv", "c.csv"))
    alone = detection_limits(SimpleNamespace(fitted_logs=(first,), more_logs=(), hidden=(hidden,)))
    assert alone == (f"this log could contain these calibration errors undetected: {said}",)
    three = detection_limits(
        SimpleNamespace(fitted_logs=(first, *more), more_logs=more, hidden=(hidden, {}, {"zero1": None}))
    )
    assert three == (
        f"a.csv could contain these calibration errors undetected: {said}",
        "c.csv could contain these calibration errors undetected: zero of joint 1 of any size",
    )
