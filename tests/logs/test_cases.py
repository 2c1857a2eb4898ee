"""Logs that people have: small files of one simulated arm, in the forms that loggers write."""

from pathlib import Path
from typing import get_args, get_type_hints

import numpy as np
import pytest
import yaml
from experiment_example import refused

import repro
from repro.identification.armfile import Arm, Units
from repro.logs.columns import SPELLINGS
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
    np.testing.assert_allclose(found.beta[:5], TRUE[:5], rtol=0.02)
    rows = found.parameters.iloc[:5]
    assert ((rows["low"] <= TRUE[:5]) & (TRUE[:5] <= rows["high"])).all()
    assert (rows["high"] - rows["low"] < 0.05 * TRUE[:5]).all()  # the joint without torque does not lower the cut-off
    assert not found.warnings


@pytest.mark.parametrize(("counts", "multiple"), [(40960, "multiples of 0.62832 rad"), (4096, "")])
def test_counts_that_wrap_before_a_full_turn_leave_multiples_of_the_zero(counts, multiple):
    log = read_log(CASES / "motor-encoder/wrap.csv", Arm(**MOTOR | {"counts_per_turn": [counts, counts]}))
    said = " ".join(log.notes)
    assert "wraps at 4096 counts" in said and multiple in said and ("multiples" in said) == bool(multiple)


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


#: How a file of another format begins, and the way to a table.
BEGINNINGS = {
    b"\x1f\x8b\x08": "gunzip --stdout",
    b"PK\x03\x04": "read_excel",
    b"PAR1": "read_parquet",
    b"\x80\x04\x95": "data frame",
    b"ULog\x01": "ulog2csv",
    b"MATLAB 7.3 MAT-file": "writetable",
    b"[\n {": "read_json",
    b"header:\n  stamp:": "the bag",
    b"\xff\xfet\x00": "iconv -f UTF-16",
    b"t,q1 [\xb0]\n": "iconv -f LATIN1",
}


@pytest.mark.parametrize(("beginning", "said"), BEGINNINGS.items(), ids=BEGINNINGS.values())
def test_another_format_has_a_way_to_a_table(tmp_path, beginning, said):
    (tmp_path / "log.csv").write_bytes(beginning + b" " * 40)
    assert said in refused(read_log, tmp_path / "log.csv", Arm()).expected


#: Header and row k of a log at 200 Hz, and what the one line says is expected.
TIMES = {
    "whole seconds": ("time,q1,q2,tau1,tau2", lambda k: f"2024-05-30 15:33:{10 + k // 200}", "sampling_rate: 200"),
    "two digits": ("time,q1,q2,tau1,tau2", lambda k: f"{0.01 * (k // 2):.2f}", "sampling_rate: 200"),
    "ns": ("time,q1,q2,tau1,tau2", lambda k: f"{5_000_000 * k}", "units: {time: ns}"),
    "days": ("time,q1,q2,tau1,tau2", lambda k: f"{7394 + 0.005 * k / 86400:.12f}", "units: {time: days}"),
    "larger arm": (
        "time,joint2_pos,joint3_pos,joint2_torque,joint3_torque",
        str,
        'q1: "joint2_pos", q2: "joint3_pos", tau1: "joint2_torque", tau2: "joint3_torque"',
    ),
    "leg": ("t,knee_pos,hip_pos,knee_tau,hip_tau", str, 'q1: "hip_pos", q2: "knee_pos", tau1: "hip_tau"'),
    "joints from 0": ("t,q_0,q_1,tau_0,tau_1", str, 'q1: "q_0", q2: "q_1", tau1: "tau_0", tau2: "tau_1"'),
    "torques in another file": ("t,q1,q2,x,y", str, "pandas.merge_asof(frame, other, on='t')"),
    "a row for each joint": ("time,joint,position,effort,velocity", str, "frame.pivot(index='time', columns='joint')"),
}


@pytest.mark.parametrize(("header", "time", "said"), TIMES.values(), ids=TIMES)
def test_a_log_whose_columns_or_times_are_unclear_is_told_what_to_write(tmp_path, header, time, said):
    rows = [f"{time(k)},{np.sin(0.01 * k):.4f},{np.cos(0.013 * k):.4f},{k % 7},{k % 11}" for k in range(2000)]
    (tmp_path / "log.csv").write_text("\n".join([header, *rows]))
    assert said in refused(read_log, tmp_path / "log.csv", Arm()).expected


#: Columns of a unit, and SI of 1 of it.
UNITS = {
    "q1 [mrad]": 1e-3,
    "tau1 [kNm]": 1e3,
    "tau1 [kgf cm]": 0.0980665,
    "tau1 [lbf.in]": 0.1129848,
    "tau1 (ozin)": 7.0615518e-3,
}


@pytest.mark.parametrize(("header", "size"), UNITS.items())
def test_units_are_converted(tmp_path, header, size):
    t = 0.01 * np.arange(400)
    table = {"time": t, "q1": np.sin(t), "q2": np.sin(1.3 * t), "tau1": np.cos(t), "tau2": np.cos(1.7 * t)}
    other = header.replace("1", "2", 1)
    renamed = {header[: header.index(" ")]: header, other[: other.index(" ")]: other}
    table = {renamed.get(name, name): x / size if name in renamed else x for name, x in table.items()}
    path = tmp_path / "log.csv"
    path.write_text(
        "\n".join([",".join(table), *(",".join(f"{x:.9f}" for x in row) for row in zip(*table.values(), strict=True))])
    )
    log = read_log(path, Arm())
    np.testing.assert_allclose([*log.q, *log.tau], [np.sin(t), np.sin(1.3 * t), np.cos(t), np.cos(1.7 * t)], atol=1e-6)


def test_every_unit_of_a_header_may_be_in_the_arm_file():
    hints = get_type_hints(Units)
    assert {kind: set(get_args(hints[kind])) for kind in SPELLINGS} == {k: set(u) for k, u in SPELLINGS.items()}


@pytest.mark.parametrize("noise", [np.nan, 0.03])
def test_a_torque_of_a_joint_without_a_drive_may_be_anything(tmp_path, noise):
    written = (CASES / "passive-joint/zero_torque.csv").read_text().replace(",0\n", f",{noise}\n")
    path = tmp_path / "log.csv"
    path.write_text(written)
    assert "passive_joint: 2" in refused(read_log, path, Arm()).expected
    log = read_log(path, Arm(passive_joint=2))
    assert not log.tau[1].any() and any("not used" in note for note in log.notes)


def test_friction_in_proportion_to_its_load_is_not_sought_in_a_joint_without_a_drive():
    path = CASES / "passive-joint/zero_torque.csv"
    found = repro.identify(path, method="ordinary").details.friction
    assert "load2" not in {term.name for terms in found for term in terms}


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
