"""Logs: whatever the units, order and spelling of the columns, the same SI signals come out."""

from dataclasses import replace

import numpy as np
import pytest
from experiment_example import refused
from fake_board import CONTROL, metadata, motion
from log_example import assert_same, columns, recording, text, write

from repro.board.capture import to_table, write_capture
from repro.board.frames import encode
from repro.identification.armfile import Arm
from repro.identification.log import uniform
from repro.logs.diagnostics import describe
from repro.logs.load import read_log

GOOD = recording()
TABLE = columns(GOOD)
DEGREE = 180 / np.pi


@pytest.fixture
def read(tmp_path):
    def write_and_read(table, arm=None, name="log.csv"):
        path = tmp_path / name
        path.write_text(table if isinstance(table, str) else text(table, 15), encoding="utf-8")
        return read_log(path, arm or Arm())

    return write_and_read


def test_a_plain_log(read):
    log = read(TABLE)
    assert_same(log, GOOD)
    assert (log.name, log.simulated, log.torque_limit) == ("log.csv", False, None)
    assert len(log.notes) == 1  # units are assumed
    assert uniform(log) is log
    for key, value in (("units", {"time": "s"}), ("torque_constant", (1.0, 2.0)), ("counts_per_turn", (9.0, 8.0))):
        assert refused(read_log, log, Arm(**{key: value})).place == f"arm file: {key}"
    lonely = read({name: values for name, values in TABLE.items() if name != "dq1"})
    assert lonely.dq is None and any("dq2" in note for note in lonely.notes)


def each(first, second):
    return np.array([[first], [second]])


#: Headers for time, positions, velocities and torques, what the values in them are multiplied by, and the arm.
SPELLINGS = {
    "brackets": ("Time [s]|q1 [rad]|q2 [rad]|dq1 [rad/s]|dq2 [rad/s]|tau1 [Nm]|tau2 [N·m]", (1, 1, 1, 1), {}),
    "parentheses": ("t (ms)|pos1 (deg)|pos2 (°)|vel1 (deg/s)|vel2 (°/s)|torque1 (mNm)|torque2 (Nmm)",
                    (1e3, DEGREE, DEGREE, 1e3), {}),
    "suffixes": ("time_us|q1_deg|q2_deg|dq1_deg_s|dq2_degps|tau1_mNm|tau2_mN_m", (1e6, DEGREE, DEGREE, 1e3), {}),
    "slashes": ("timestamp/ns|theta1/rad|theta2/rad|qd1/(rad/s)|qd2/rad/s|u1/Nm|u2/N m", (1e9, 1, 1, 1), {}),
    "underscores": ("T_min|Q_1|Q_2|q_dot_1|q_dot_2|TAU_1|TAU_2", (1 / 60, 1, 1, 1), {}),
    "joint first": ("t|joint1_pos|joint2_pos|joint1_vel_rpm|joint2_vel_rpm|joint1_torque|joint2_torque",
                    (1, 1, 30 / np.pi, 1), {}),
    "shoulder and elbow": ("time|shoulder_pos|elbow_pos|shoulder_velocity|elbow_velocity|shoulder_torque|tau_elbow",
                           (1, 1, 1, 1), {}),
    "current": ("time|position1|position2|velocity1|velocity2|current1|current_2", (1, 1, 1, each(10, 4)),
                {"torque_constant": (0.1, 0.25)}),
    "milliamperes": ("time|q1|q2|dq1|dq2|current1 [mA]|current2_mA", (1, 1, 1, each(1e4, 4e3)),
                     {"torque_constant": (0.1, 0.25)}),
    "counts": ("time|q1_counts|q2 [ticks]|dq1 [counts/s]|dq2 [ticks/s]|pwm1|pwm2",
               (1, each(8400, 4096) / 2 / np.pi, each(8400, 4096) / 2 / np.pi, each(250, 125)),
               {"counts_per_turn": (8400, 4096), "torque_constant": (0.004, 0.008)}),
    "arm file wins": ("t [s]|q1 [rad]|q2|dq1|dq2|tau1 [furlong]|tau2", (1e3, DEGREE, 30 / np.pi, 1e3),
                      {"units": {"time": "ms", "position": "deg", "velocity": "rpm", "torque": "mN m"}}),
    "quoted": ('"time"|"q1 [rad]"|"q2_rad"|dq1|dq2|"tau1"|tau2', (1, 1, 1, 1), {}),
    "effort": ("time|joint1.position|joint2.position|joint_1_velocity|joint_2_velocity|joint1.effort|effort2",
               (1, 1, 1, 1), {}),
    "any names": ("PKT|Schulter|Ellenbogen|wS|wE|MS [N cm]|ME [mNm]", (1, 1, 1, each(1e2, 1e3)),
                  {"columns": {"time": "PKT", "q1": "Schulter", "q2": "Ellenbogen", "dq1": "wS", "dq2": "wE",
                               "tau1": "MS [N cm]", "tau2": "ME [mNm]"}}),
    "measured": ("time|pos_meas1|pos_meas2|q1_dot|q2_dot|tau_meas1|tau2_measured", (1, 1, 1, 1), {}),
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("spelling", SPELLINGS)
def test_units_and_names_do_not_matter(read, spelling):
    header, (time, position, velocity, torque), arm = SPELLINGS[spelling]
    values = (GOOD.t * time, *(GOOD.q * position), *(GOOD.dq * velocity), *(GOOD.tau * torque))
    assert_same(read(dict(zip(header.split("|"), values, strict=True)), Arm(**arm)), GOOD)


def test_signs_zeros_and_absolute_angles_are_put_right(read):
    zero, sign = each(0.4, -1.1), each(-1.0, 1.0)
    absolute, velocity = (np.stack([x[0], x[0] + x[1]]) for x in (GOOD.q, GOOD.dq))
    values = (GOOD.t, *(sign * absolute + zero), *(sign * velocity), *(each(0.2, -0.3) - each(2.0, 0.5) * GOOD.tau))
    arm = Arm(sign=(-1, 1), torque_sign=(1, -1), zero=(0.4, -1.1), second_joint_absolute=True, torque_limit=(9, 3))
    arm = replace(arm, torque_offset=(0.2, -0.3), torque_scale=(2.0, 0.5))
    log = read(dict(zip(TABLE, values, strict=True)), arm)
    assert_same(log, GOOD)
    assert log.torque_limit.tolist() == [9.0, 3.0]


@pytest.mark.parametrize(
    ("old", "new"),
    [("time", "# notes\n#\n\ntime"), ("time", "\ufefftime"), ("\n", "\r\n"), ("\n", "\r"), (",", ", "), ("\n", "\n\n")],
)
def test_what_surrounds_the_numbers_does_not_matter(tmp_path, old, new):
    assert_same(read_log(write(tmp_path, text(TABLE, 15).replace(old, new)), Arm()), GOOD)


def test_wrapped_angles_are_unwrapped_and_noted(read):
    q = GOOD.q + 2.6
    log = read(TABLE | dict(zip(("q1", "q2"), (q + np.pi) % (2 * np.pi) - np.pi, strict=True)), Arm(zero=(2.6, 2.6)))
    assert len(log.notes) == len(read(TABLE, Arm(zero=(2.6, 2.6))).notes) + 2
    turns = (log.q - GOOD.q) / (2 * np.pi)
    np.testing.assert_allclose(turns, np.rint(turns[:, :1]) + 0 * turns, atol=1e-9)
    assert describe(log, Arm()).warnings == ()


def test_a_quantised_log_is_as_good(read):
    step = 2 * np.pi / 4096
    table = TABLE | {name: np.rint(TABLE[name] / step) for name in ("q1", "q2")}
    table |= {name: np.rint(TABLE[name] / 0.005) for name in ("tau1", "tau2")}
    units = {"position": "counts", "torque": "counts"}
    arm = Arm(units=units, counts_per_turn=(4096, 4096), torque_constant=(0.005, 0.005))
    log = read(table, arm)
    assert_same(log, GOOD, q=0.51 * step, tau=0.0026)
    description = describe(log, arm)
    assert {("step of position 2", f"{step:.3g} rad"), ("step of torque 1", "0.005 N m")} <= set(description.facts)
    assert description.warnings == ()


@pytest.mark.parametrize("board", [None, {"name": "simulated"}])
def test_a_capture_is_a_log_and_its_table_the_same_log(tmp_path, read, board):
    desired, position, pwm = motion(1000)
    capture = write_capture(tmp_path / "T4.bin", encode(position, pwm), metadata(desired, board=board))
    log = read_log(tmp_path / "T4.bin", Arm(units={"position": "deg"}))
    assert log.simulated == (board is not None)
    np.testing.assert_allclose(log.t, 0.0025 * np.arange(1000), rtol=1e-12)
    np.testing.assert_allclose(log.q, position * 2 * np.pi / 8400, rtol=1e-12)
    full = np.array(CONTROL.full_torque)
    np.testing.assert_allclose(log.tau, pwm * full[:, np.newaxis] / 1023, rtol=1e-12)
    np.testing.assert_allclose(log.torque_limit, full)
    assert describe(log, Arm()).simulated == log.simulated
    assert read_log(tmp_path / "T4.bin", Arm(torque_limit=(1.0, 2.0))).torque_limit.tolist() == [1.0, 2.0]
    scaled = Arm(torque_offset=(-0.5, 0.25), torque_scale=(2.0, 0.5))
    np.testing.assert_allclose(read_log(tmp_path / "T4.bin", scaled).torque_limit, (full - [0.5, 0.25]) * [0.5, 2.0])
    arm = Arm(counts_per_turn=(8400, 8400), topic="/joints", file="arm.yaml")
    decoded = read(to_table(capture).to_csv(index=False), arm, "T4.csv")
    np.testing.assert_allclose([decoded.q, decoded.tau], [log.q, log.tau], atol=1e-12)
    notes = {note.partition(" of arm.yaml is not used: ")[0] for note in decoded.notes}
    assert notes >= {"q1 is read from q1_rad, in rad, of q1_rad, q1_counts", "counts_per_turn", "topic"}
    assert decoded.simulated == log.simulated
