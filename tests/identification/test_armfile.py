"""Arm files: every key is read, and what is wrong is found in one line."""

import dataclasses

import numpy as np
import pytest
import yaml
from experiment_example import refused

from repro.identification.armfile import Arm, read_arm

EVERY_KEY = """
{name: pendulum, sampling_rate: 250.0, passive_joint: 2,
columns: {q1: a, tau2: b}, topic: /joint_states, counts_per_turn: [8400, 4096.5],
units: {time: ms, position: counts, velocity: rpm, torque: A}, torque_constant: [0.6, -0.5], torque_offset: [0.1, -0.2],
torque_scale: [1, 2], sign: [1, -1], torque_sign: [-1, 1], zero: [0, -1.5708], second_joint_absolute: true,
torque_limit: [6, 5.5], position_limit: [[-1, 2], [0.5, 1]], speed_limit: [3, 4.5], workspace: [[-0.5, 0.5], [-1, 0]],
plane: horizontal, gravity: 9.81, link_lengths: [0.3, 0.2],
link_length_sd: 0.002, friction_steepness: auto, delay: 0.01}"""


def test_every_key_of_an_arm_file_is_read(tmp_path):
    content = yaml.safe_load(EVERY_KEY)
    path = tmp_path / "arm.yaml"
    path.write_text(EVERY_KEY)
    arm = read_arm(path)
    assert {field.name for field in dataclasses.fields(Arm)} == {*content, "file"}
    for key, value in content.items():
        expected = None if value == "auto" else value
        assert np.array_equal(getattr(arm, key), expected), key
        assert not isinstance(getattr(arm, key), list)
    path.write_text("friction_steepness: 1e2\ndelay: auto\n")  # no point, which YAML 1.1 takes for text
    assert (read_arm(path).friction_steepness, read_arm(path).delay) == (100.0, None)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("content", "place", "found"),
    [
        ("file: a.yaml\n", "file", "'a.yaml'"),
        ("name:\n", "name", "None"),
        ("colour: red\n", "colour", "an unknown key"),
        ("self: 1\n", "self", "an unknown key"),
        ("columns: {q3: a}\n", "columns.q3", "an unknown key"),
        ("units: {position: gon}\n", "units.position", "'gon'"),
        ("units: deg\n", "units", "'deg'"),
        ("columns: {q1: a, q2: a}\n", "columns", "{'q1': 'a', 'q2': 'a'}"),
        ("counts_per_turn: 8400\n", "counts_per_turn", "8400"),
        ("counts_per_turn: [8400, 0]\n", "counts_per_turn[1]", "0"),
        ("torque_constant: [0.1, 0]\n", "torque_constant[1]", "0"),
        ("torque_constant: [0.1]\n", "torque_constant[1]", "nothing"),
        ("sign: [1, 2]\n", "sign[1]", "2"),
        ("sign: [0.5, 1]\n", "sign[0]", "0.5"),
        ("sign: [1, true]\n", "sign[1]", "True"),
        ("zero: [.nan, 0]\n", "zero[0]", "nan"),
        ("zero: [180, 0]\n", "zero[0]", "180"),
        ("position_limit: [[-1, 1], [-90, 9]]\n", "position_limit[1][0]", "-90"),
        ("speed_limit: [6, 300]\n", "speed_limit[1]", "300"),
        ("zero: [a, 0]\n", "zero[0]", "'a'"),
        ("position_limit: [-1, 1]\n", "position_limit[0]", "-1"),
        ("workspace: [[-1, 1], [0, -1]]\n", "workspace[1]", "[0, -1]"),
        ("speed_limit: [1, 0]\n", "speed_limit[1]", "0"),
        ("gravity: .inf\n", "gravity", "inf"),
        ("gravity: -9.81\n", "gravity", "-9.81"),
        ("gravity: 9,81\n", "gravity", "'9,81'"),
        ("second_joint_absolute: 1\n", "second_joint_absolute", "1"),
        ("friction_steepness: 0\n", "friction_steepness", "0"),
        ("friction_steepness: Auto\n", "friction_steepness", "'Auto'"),
        ("delay: 5\n", "delay", "5"),
        ("name: ''\n", "name", "''"),
        ('name: "a\\u001b[31mb"\n', "name", "'a\\x1b[31mb'"),
        ('name: "\\ud800"\n', r"line 1: name", r"'\ud800'"),
        ("name: 7\n", "name", "7"),
        ("gravity: 9.8\ngravity: 9.9\n", "line 2", "the key 'gravity' twice"),
        ("7: a\n", "line 1", "the key '7'"),
        ("gravity: [\n", "", "text that is not YAML"),
        (b"name: \xff\n", "", "text that is not YAML"),
        ("- 1\n", "", "[1]"),
        ("torque_scale: [1, 1e+308]\n", "torque_scale[1]", "1e+308"),
        ("speed_limit: [1e-300, 6]\n", "speed_limit[0]", "1e-300"),
        ("position_limit: [[0, 1e-300], [0, 1]]\n", "position_limit[0]", "[0, 1e-300]"),
        ("a: " + "[" * 51 + "]" * 51, "line 1", "lists within lists"),
        (f"gravity: 1{'0' * 400}\n", "line 1: gravity", "'1000"),
    ],
)
def test_an_arm_file_that_is_wrong_is_reported_in_one_line(tmp_path, content, place, found):
    path = tmp_path / "arm.yaml"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    error = refused(read_arm, path)
    assert error.place == f"{path}: {place}".removesuffix(": ") and error.found.startswith(found)


@pytest.mark.parametrize(
    ("values", "field"),
    [({"name": None}, "name"), ({"zero": (0, -90)}, "zero[1]"), ({"sgin": (1, -1)}, "sgin")],
)
def test_an_arm_built_by_hand_is_checked_as_a_file_is(values, field):
    assert refused(Arm, **values).place == f"arm file: {field}"
