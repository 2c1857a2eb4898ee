"""Logs that people have: small files of one simulated arm, in the forms that loggers write."""

from pathlib import Path

import numpy as np
import pytest
import yaml
from experiment_example import refused

import repro
from repro.identification.armfile import Arm
from repro.logs.load import read_log

CASES = Path(__file__).parent / "cases"
#: The arm behind every file: I1, I2, I3, g1, g2, b1, b2, k1, k2.
TRUE = np.array([0.14, 0.065, 0.028, 3.4, 1.05, 0.05, 0.03, 0.15, 0.10])
MOTOR = yaml.safe_load((CASES / "motor-encoder/arm.yaml").read_text())
#: File, what the arm file has to state, and a word of the note that says how it was read; empty for none.
READ = {
    "revolutions": ("turns/rev.csv", {}, "from turns"),
    "revolutions without a unit": ("turns/no_unit.csv", {"units": {"position": "turns"}}, "from turns"),
    "dates": ("time/iso.csv", {}, "dates"),
    "a counter that wraps": ("time/micros_wrap.csv", {}, "32 bits"),
    "bursts": ("time/bursts.csv", {"sampling_rate": 100.0}, "is not used"),
    "no times": ("time/no_time.csv", {"sampling_rate": 100.0}, ""),
    "a line of units": ("table/units_row.csv", {}, "states units"),
    "lines before the header": ("table/preamble.csv", {}, "before the header"),
    "a header in a comment with %": ("table/percent_header.txt", {}, "blanks"),
    "two topics": ("separate-messages/two_topics.csv", {}, "different instants"),
    "a message for each joint": ("separate-messages/bag", {}, "merged"),
}


@pytest.mark.parametrize(("file", "arm", "note"), READ.values(), ids=READ)
def test_a_log_is_read_as_what_it_is(file, arm, note):
    usual = read_log(CASES / "turns/rev.csv", Arm())  # the same motion
    log = read_log(CASES / file, Arm(**arm))
    n = min(log.t.size, usual.t.size, 390)
    assert n == 390
    np.testing.assert_allclose(log.t[:n], 0.01 * np.arange(n), atol=2e-3)
    first = 1 if "instants" in note else 0  # before the first torque there is none
    q, tau = usual.q[:, first : n + first], usual.tau[:, first : n + first]
    assert np.abs(log.q[:, :n] - q).max() < 1e-4
    error = np.sqrt(np.mean((log.tau[:, :n] - tau) ** 2) / np.mean(tau**2))
    assert error < 0.05 if "instants" in note else error < 1e-4
    assert note in " ".join(log.notes)


def test_a_header_that_is_a_comment_is_read_with_rows_that_have_words():
    columns = {"q1": "field.position0", "q2": "field.position1", "tau1": "field.effort0", "tau2": "field.effort1"}
    log = read_log(CASES / "hints/rostopic.csv", Arm(columns=columns, units={"time": "ns"}))
    assert log.t[-1] == pytest.approx(0.01 * (log.t.size - 1), abs=1e-6)


@pytest.mark.parametrize(
    ("file", "arm"),
    [
        ("relay-torque/relay.csv", {}),
        # The first count is known but for multiples of 4096, a tenth of a turn.
        ("motor-encoder/wrap.csv", {**MOTOR, "zero": [-0.2 * np.pi, 0.0]}),
    ],
)
def test_an_unusual_drive_or_encoder_gives_the_arm(file, arm):
    found = repro.identify(CASES / file, arm=Arm(**arm), method="consistent")
    np.testing.assert_allclose(found.beta[[0, 1, 2, 3, 4]], TRUE[:5], rtol=0.12)


@pytest.mark.parametrize(("file", "arm"), [("zero_torque", {}), ("no_column", {"passive_joint": 2})])
def test_a_joint_without_a_drive_is_fitted(file, arm):
    path = CASES / f"passive-joint/{file}.csv"
    found = repro.identify(path, arm=Arm(**arm), method="consistent")
    np.testing.assert_allclose(found.beta[:5], TRUE[:5], rtol=0.06)
    rows = found.parameters.iloc[:5]
    assert ((rows["low"] <= TRUE[:5]) & (TRUE[:5] <= rows["high"])).all()


#: File, and what the one line says is expected.
REFUSED = {
    "time/bursts.csv": "sampling_rate: 100",
    "passive-joint/no_column.csv": "passive_joint: 2",
    "time/no_time.csv": 'if it has none; for arm.yaml, to correct: columns: {time: "HEADER", q1: "q1", q2: "q2"',
    "table/header_again.csv": "",
    "hints/rtde.csv": '{time: "timestamp", q1: "actual_q_0", q2: "actual_q_1", tau1: "actual_current_0"',
    "hints/rostopic.csv": '{time: "time", q1: "field.position0", q2: "field.position1", tau1: "field.effort0"',
    "formats/matlab.mat": "writetable",
    "formats/log.jsonl": "read_json",
    "formats/ros1.bag": "",
}


@pytest.mark.parametrize(("file", "said"), REFUSED.items())
def test_a_log_that_cannot_be_read_is_told_what_to_do(file, said):
    assert said in refused(read_log, CASES / file, Arm()).expected


def test_positions_in_turns_without_a_unit_are_told_so():
    found = repro.identify(CASES / "turns/no_unit.csv", method="bounded")
    assert any("units: {position: turns}" in warning for warning in found.warnings)


def test_logs_that_each_move_one_joint_complete_each_other():
    logs = [CASES / f"joint-by-joint/joint{joint}.csv" for joint in (1, 2)]
    found = repro.identify(logs)
    np.testing.assert_allclose(found.beta, TRUE, rtol=0.04)
    rows = found.parameters
    assert ((rows["low"] <= TRUE) & (rows["high"] >= TRUE)).sum() >= 8  # of nine intervals of 95 %
    assert (rows["high"] - rows["low"] < 0.02 * TRUE)[:5].all()
    assert set(found.errors["part"]) == {"fit", "half"}  # neither log alone can predict the other
    assert not found.unusable
    assert not any("disagrees" in line for line in found.warnings)
