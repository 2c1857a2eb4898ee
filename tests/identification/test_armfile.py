"""Arm files: every key is read, and what is wrong is found in one line."""

import dataclasses
import re

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
    ("content", "found"),
    [
        ("file: a.yaml\n", "file: found 'a.yaml', expected a key of an arm, with a value"),
        ("name:\n", "name: found None, expected a key of an arm, with a value"),
        ("colour: red\n", "colour: found an unknown key, expected one of name, columns"),
        ("self: 1\n", "self: found an unknown key, expected one of name, columns"),
        ("columns: {q3: a}\n", "columns.q3: found an unknown key, expected one of 'time', 'q1'"),
        ("units: {position: gon}\n", "units.position: found 'gon', expected 'rad', 'deg', 'counts' or 'turns'"),
        ("units: deg\n", "units: found 'deg', expected units by kind of signal"),
        ("columns: {q1: a, q2: a}\n", "columns: found {'q1': 'a', 'q2': 'a'}, expected a different column for each"),
        ("counts_per_turn: 8400\n", "counts_per_turn: found 8400, expected two numbers above 0"),
        ("counts_per_turn: [8400, 0]\n", "counts_per_turn[1]: found 0, expected two numbers above 0"),
        ("torque_constant: [0.1, 0]\n", "torque_constant[1]: found 0, expected two numbers other than 0"),
        ("torque_constant: [0.1]\n", "torque_constant[1]: found nothing, expected two numbers"),
        ("sign: [1, 2]\n", "sign[1]: found 2, expected two numbers, each 1 or -1"),
        ("sign: [0.5, 1]\n", "sign[0]: found 0.5, expected two numbers, each 1 or -1"),
        ("sign: [1, true]\n", "sign[1]: found True, expected two numbers"),
        ("zero: [.nan, 0]\n", "zero[0]: found nan, expected two numbers, the position"),
        ("zero: [180, 0]\n", "zero[0]: found 180, expected radians within a turn"),
        ("position_limit: [[-1, 1], [-90, 9]]\n", "position_limit[1][0]: found -90, expected radians within two turns"),
        ("speed_limit: [6, 300]\n", "speed_limit[1]: found 300, expected rad/s up to ten turns a second, whatever"),
        ("zero: [a, 0]\n", "zero[0]: found 'a', expected two numbers"),
        ("position_limit: [-1, 1]\n", "position_limit[0]: found -1, expected two ranges, lowest and highest angle"),
        ("workspace: [[-1, 1], [0, -1]]\n", "workspace[1]: found [0, -1], expected the lower one first"),
        ("speed_limit: [1, 0]\n", "speed_limit[1]: found 0, expected two numbers above 0, the largest speed"),
        ("gravity: .inf\n", "gravity: found inf, expected a number above 0, m/s^2 (a finite number)"),
        ("gravity: -9.81\n", "gravity: found -9.81, expected a number above 0"),
        ("gravity: 9,81\n", "gravity: found '9,81', expected a number above 0"),
        ("second_joint_absolute: 1\n", "second_joint_absolute: found 1, expected true or false"),
        ("friction_steepness: 0\n", "friction_steepness: found 0, expected a number above 0, s/rad, or auto"),
        ("friction_steepness: Auto\n", "friction_steepness: found 'Auto', expected a number"),
        ("delay: 5\n", "delay: found 5, expected a number from -1 to 1, s, or auto"),
        ("name: ''\n", "name: found '', expected text"),
        ('name: "a\\u001b[31mb"\n', "name: found 'a\\x1b[31mb', expected text on one line"),
        ('name: "\\ud800"\n', r"line 1: name: found '\ud800', expected characters that UTF-8 can hold"),
        ("name: 7\n", "name: found 7, expected text"),
        ("gravity: 9.8\ngravity: 9.9\n", "line 2: found the key 'gravity' twice, expected"),
        ("7: a\n", "line 1: found the key '7', expected text as key"),
        ("gravity: [\n", "found text that is not YAML"),
        (b"name: \xff\n", "found text that is not YAML"),
        ("- 1\n", "found [1], expected keys with values"),
        ("torque_scale: [1, 1e+308]\n", "torque_scale[1]: found 1e+308, expected two numbers above 0"),
        ("speed_limit: [1e-300, 6]\n", "speed_limit[0]: found 1e-300, expected two numbers above 0, the largest"),
        ("position_limit: [[0, 1e-300], [0, 1]]\n", "position_limit[0]: found [0, 1e-300], expected ends"),
        ("a: " + "[" * 51 + "]" * 51, "found lists within lists"),
        (f"gravity: 1{'0' * 400}\n", "line 1: gravity: found '1000"),
    ],
)
def test_an_arm_file_that_is_wrong_is_reported_in_one_line(tmp_path, content, found):
    path = tmp_path / "arm.yaml"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    line = refused(read_arm, path)
    assert str(path) in line and found in line


@pytest.mark.parametrize(
    ("values", "found"),
    [
        ({"name": None}, ": name: found "),
        ({"zero": (0, -90)}, r": zero\[1\]: found "),
        ({"sgin": (1, -1)}, r"^arm file: sgin: found an unknown key, expected sign, or one of \d+ others$"),
    ],
)
def test_an_arm_built_by_hand_is_checked_as_a_file_is(values, found):
    assert re.search(found, refused(Arm, **values))
