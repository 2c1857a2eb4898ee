"""Every kind of bad log is found in one line: what was found and what to do."""

import numpy as np
import pytest
import yaml
from kept import same
from log_damage import (
    COARSE_TIME,
    DEGREE,
    GOOD,
    NOISE,
    TIME_BACK,
    TWICE,
    N,
    absolute,
    cell,
    fast_motion,
    gaps,
    good,
    held,
    line_changed,
    offset,
    other_sign,
    renamed,
    rows,
    saturated,
    scaled,
    shifted,
    shifted_torque,
    slow_rate,
    swapped,
    without,
    without_velocity,
)
from log_example import BETA, motion, text

from repro.errors import InputError
from repro.logs import torque_limits
from repro.logs.armfile import Arm, read_arm
from repro.logs.diagnostics import describe, diagnose
from repro.logs.load import read_log
from repro.logs.log import Log, uniform
from repro.model.dynamics import forward_dynamics

#: Name, content of the file (table, text or bytes), keys of the arm, words of the error.
#: An arm file that states the unit of an absurd position.
RAD = {"units": {"position": "rad"}}

REFUSED = [
    ("empty", b"", {}, "found an empty file, expected a CSV table"),
    ("blank lines only", "\n\n  \n", {}, "found an empty file"),
    ("header only", ",".join(GOOD) + "\n", {}, "found a header and no samples"),
    ("comments only", "# time\n# q1\n", {}, "found no header"),
    ("binary", bytes(range(256)) * 40, {}, "found binary data (byte 0x00 at offset 0)"),
    ("spreadsheet", b"PK\x03\x04" + b"x" * 500, {}, "found a compressed file or a spreadsheet"),
    ("UTF-16", text(good()).encode("utf-16"), {}, "found UTF-16 text, expected UTF-8"),
    ("Latin-1", text(renamed(q1="q1 [°]")).encode("latin-1"), {}, "found byte 0xb0 in line 1, which is not UTF-8"),
    ("prose", "Dear reader,\nthis is no log.\n", {}, "line 2: found 1 cells (the last line, cut off: delete it)"),
    ("one column", "time\n0\n1\n", {}, "line 1: found one column (time), expected columns separated by commas"),
    ("two separators", "time,s;state\n0,idle;1\n", {}, "line 1: found columns that may be separated by commas or"),
    ("two decimal marks", text(cell("q1", 7, "1|5")).replace(",", ";").replace("|", ","), {}, "line 9, column q1:"),
    ("decimals or groups", "time;q1;q2;tau1;tau2\n" + "0;1,234;1,234;1,234;1,234\n" * 300, {}, "line 2, column q1:"),
    ("blanks in a name", text(renamed(q1="q1 [deg]")).replace(",", " "), {}, "line 2: found 7 cells, expected 8"),
    ("decimal commas", line_changed(lambda s: s.replace(".", ",")), {}, "(decimal commas?), expected 7"),
    ("no header", text(good()).partition("\n")[2], {}, "line 1: found numbers (0,"),
    ("no header but empty cells", "0,NaN,1,2,3\n" * 300, {}, "line 1: found numbers (0,NaN"),
    ("a column twice", text(good()).replace("dq2", "dq1", 1), {}, "header: found the column 'dq1' twice"),
    ("a row too long", line_changed(lambda s: s + ",1"), {}, "line 100: found 8 cells, expected 7"),
    ("a comma at the end", line_changed(lambda s: s + ","), {}, "line 100: found 8 cells (a separator at its end)"),
    ("a row too short", line_changed(lambda s: s.rpartition(",")[0]), {}, "line 100: found 6 cells, expected 7"),
    ("cut off", text(good())[:-40], {}, "cut off: delete it"),
    ("text in a cell", cell("q2", 7, "broken"), {}, "line 9, column q2: found 'broken', expected a finite number"),
    ("header twice", line_changed(lambda s: ",".join(GOOD)), {}, "line 100, column time: found 'time'"),
    ("infinite", cell("tau2", 50, "-inf"), {}, "line 52, column tau2: found '-inf'"),
    ("too large", cell("q1", 50, "1e999"), {}, "line 52, column q1: found '1e999'"),
    ("empty column", good() | {"tau2": ["NaN"] * N}, {}, "line 2: found an empty cell there and in 2399 more of 2400"),
    ("digits in groups", cell("q1", 50, "1_000"), {}, "line 52, column q1: found '1_000'"),
    ("clock time", cell("time", 0, "12:00:01.5"), {}, "line 2, column time: found '12:00:01.5'"),
    ("torque missing", without("tau1", "tau2"), {}, "expected a column for tau1, tau2; for arm.yaml, to correct"),
    ("one position missing", without("q2"), {}, "found the columns time, q1, dq1, dq2, tau1, tau2, expected a column"),
    ("many columns", {**without("q2"), **{f"extra{k}": NOISE[0] for k in range(8)}}, {}, "extra2, extra3 and 4 more, "),
    ("misspelt", renamed(tau1="tauu1"), {}, "expected a column for tau1 (perhaps 'tauu1' for tau1)"),
    ("joints from 0", renamed(q1="q0", q2="q1"), {}, "found columns of a joint 0: q0, expected joints 1 and 2"),
    (
        "degrees without a unit",
        scaled(1 / DEGREE, "q1", "q2"),
        {},
        "turns if it is rad, expected in the arm file units: {position: deg}",
    ),
    ("a third joint", {**good(), "q0": good()["q1"], "tau0": good()["tau1"]}, {}, "found columns of a joint 0: q0,"),
    ("ambiguous", renamed(dq1="pos1"), {}, "found 2 columns for q1: q1, pos1, expected one"),
    (
        "two units",
        renamed(q1="q1 [rad]", dq1="q1 [deg]"),
        {},
        "found 2 columns for q1: q1 [rad], q1 [deg], expected one",
    ),
    ("unknown unit", renamed(q1="q1 [grad]"), {}, "column q1 [grad]: found the unit 'grad', expected a unit of"),
    (
        "unknown unit of a named column",
        renamed(tau1="Moment [kgm]"),
        {"columns": {"tau1": "Moment [kgm]"}},
        "column Moment [kgm]: found the unit 'kgm', expected a unit of torque",
    ),
    ("a unit of something else", renamed(tau1="tau1 (rad)"), {}, "found the unit 'rad', expected a unit of torque"),
    ("counts of unknown size", renamed(q1="q1_counts", q2="q2_counts"), {}, "counts_per_turn: found nothing, expected"),
    ("current without a constant", renamed(tau1="current1", tau2="current2"), {}, "torque_constant: found nothing"),
    ("PWM without a constant", renamed(tau1="tau1_Nm", tau2="pwm2"), {}, "log.csv is in counts"),
    ("one unit of two", renamed(q1="q1 [deg]"), {}, "column q2: found no unit, expected its unit, as q1 [deg] is in"),
    ("a column not there", good(), {"columns": {"q1": "angle"}}, "columns.q1: found 'angle', expected a header of"),
    ("absurd position", cell("q1", 900, "-1e300"), RAD, "position: found 1e+300 rad, expected at most 1e+06 rad"),
    ("absurd torque", cell("tau1", 900, "1e200"), {}, "torque: found 1e+200 N m"),
    ("absurd time", cell("time", 2399, "1e300"), {}, "time: found 1e+300 s"),
    ("a burst and a pause", rows(np.r_[:199, 2399]), {}, "time: found 1 gap of up to 11 s, 0.99 s (199 samples)"),
    ("10 samples", rows(slice(10)), {}, "found 10 samples, expected at least 200"),
    ("1 s", rows(slice(250)), {}, "found 1.25 s, expected at least 2 s"),
    ("backward time", TIME_BACK, {}, "line 1002, time: found 4.98 s after 4.995 s, expected time that increases"),
    ("the same time twice", TWICE, {}, "line 502, time: found 2.495 s twice, expected time that increases"),
    ("coarse time", COARSE_TIME, {}, "twice (too few digits?)"),
    ("constant time", held(1, "time"), {}, "line 3, time: found 1 s twice"),
    ("reversed", rows(slice(None, None, -1)), {}, "line 3, time: found 11.99 s after 11.995 s"),
    ("milliseconds", scaled(1e3, "time"), {}, "a rate of 0.2 Hz, expected 5 to 20000 Hz, unless time is in ms (200"),
    ("nanoseconds", scaled(1e9, "time"), {}, "found a period of 5e+06 s, so a rate of 2e-07 Hz"),
    ("seconds for milliseconds", good(), {"units": {"time": "ms"}}, "found a period of 0.005 ms, so a rate of 2e+05"),
    ("minutes", scaled(1 / 3600, "time"), {}, "so a rate of 7.2e+05 Hz"),
    ("one sample a second", slow_rate(1.0), {}, "so a rate of 1 Hz, expected 5 to 20000 Hz"),
    ("gaps everywhere", gaps(1.5), {}, "time: found 7 gaps of up to 1.01 s"),
    ("an arm at rest", held(0.3, "q1", "q2"), {}, "position: found an arm that does not move (0 and 0 rad)"),
    ("zero torque", held(0, "tau1", "tau2"), {}, "torque of joint 1: found zero throughout, expected a torque that"),
    ("constant torque", held(1.5, "tau2"), {}, "torque of joint 2: found 1.5 N m throughout"),
    ("saturated throughout", saturated(0.05), {}, "torque of joint 1: found saturated throughout (9"),
    ("beyond a known limit", good(), {"torque_limit": (0.05, 9.0)}, "found saturated throughout"),
]

#: Name, table, keys of the arm, words of the warning.
SUSPECTED = [
    ("degrees", scaled(1 / DEGREE, "q1", "q2"), RAD, "position in deg, taken for rad"),
    ("degrees, no velocity", without_velocity(scaled(1 / DEGREE, "q1", "q2")), RAD, "with positions in degrees"),
    ("degrees throughout", scaled(1 / DEGREE, "q1", "q2", "dq1", "dq2"), RAD, "turns): if these are degrees or counts"),
    ("radians for degrees", good(), {"units": {"position": "deg"}}, "or position in rad, taken for deg"),
    ("velocity in deg/s", scaled(1 / DEGREE, "dq1", "dq2"), {}, "57.3 times the differentiated position"),
    ("velocity in rpm", scaled(30 / np.pi, "dq1", "dq2"), {}, "velocity in rpm"),
    ("velocity of the other sign", other_sign("dq2"), {}, "velocity of joint 2: the opposite sign"),
    ("velocities swapped", swapped(good(), ("dq1", "dq2")), {}, "velocity columns of joints 1 and 2 are swapped"),
    ("velocity of something else", good() | dict(zip(("dq1", "dq2"), NOISE, strict=True)), {}, "not the derivative"),
    ("velocity not filled in", held(0, "dq1", "dq2"), {}, "not the derivative of the position (correlation 0.00)"),
    ("velocity twice as large", scaled(2, "dq1"), {}, "2 times the differentiated position"),
    ("positions in counts", without_velocity(scaled(4096 / 2 / np.pi, "q1", "q2")), RAD, "if these are degrees or"),
    ("swapped joints", swapped(good(), ("q1", "q2"), ("dq1", "dq2"), ("tau1", "tau2")), {}, "joints 1 and 2 swapped"),
    ("swapped torques", swapped(good(), ("tau1", "tau2")), {}, "with the torques of joints 1 and 2 swapped"),
    ("torque of the other sign", other_sign("tau1", "tau2"), {}, "with the torques of the other sign"),
    ("torque 1 of the other sign", other_sign("tau1"), {}, "with the torque of joint 1 of the other sign"),
    ("torque 2 of the other sign", other_sign("tau2"), {}, "with the torque of joint 2 of the other sign"),
    ("joint 2 of the other sign", other_sign("q2", "dq2", "tau2"), {}, "with joint 2 of the other sign"),
    ("absolute q2", absolute(), {}, "with q2 measured from the vertical"),
    ("q2 not absolute", good(), {"second_joint_absolute": True}, "with q2 relative to link 1"),
    ("q2 of the other sign", other_sign("q2", "dq2"), {}, "sign: [1, -1] and torque_sign: [1, -1]"),
    ("zero upright", offset(np.pi, 0), {}, "with q1 = 0 upright"),
    ("zero horizontal", offset(np.pi / 2, 0), {}, "zero: [1.5708, 0]"),
    ("zero horizontal, other side", offset(-np.pi / 2, 0), {}, "zero: [-1.5708, 0]"),
    ("zero folded back", offset(0, np.pi), {}, "with q2 = 0 folded back"),
    ("zero at a right angle", offset(0, np.pi / 2), {}, "zero: [0, 1.5708]"),
    ("q1 in half as many counts", scaled(2, "q1", "dq1"), {}, "multiply counts_per_turn by [2, 1] in the arm file"),
    ("q2 in four times the counts", scaled(0.25, "q2", "dq2"), {}, "multiply counts_per_turn by [1, 0.25] in"),
    ("both in twice the counts", scaled(0.5, "q1", "q2", "dq1", "dq2"), {}, "both positions 0.5 times the true one"),
    ("torque of another arm", good() | dict(zip(("tau1", "tau2"), NOISE, strict=True)), {}, "little more than noise"),
    ("torque recorded late", shifted_torque(-0.12), {}, "0.120 s earlier than recorded"),
    ("torque recorded early", shifted_torque(0.1), {}, "0.100 s later than recorded"),
    (
        "torque in counts",
        good() | {name: np.rint(GOOD[name] * 400) for name in ("tau1", "tau2")},
        {},
        "the torque of joint 1 is whole numbers up to",
    ),
    ("torque in mN m", scaled(1e3, "tau1", "tau2"), {}, "N m: if this is mN m"),
    ("saturated", saturated(2.5), {}, "the torque of joint 1 is saturated in"),
    ("beyond a known limit at times", good(), {"torque_limit": (2.5, 9.0)}, "the torque of joint 1 is saturated in"),
    ("one joint still", held(0.2, "q2"), {}, "joint 2 does not move (0 rad)"),
    ("position jumps", shifted("q1", 0.5, 1200), {}, "position of joint 1 jumps by 0.499 rad at 6 s"),
    ("a spike", shifted("q2", -2.0, 1200, 1201), {}, "position of joint 2 jumps by 1.98 rad at 6 s"),
    ("sampled too slowly", fast_motion(), {}, "record at a higher rate"),
    ("much too slow", without_velocity(scaled(0.01, "q1", "q2")), {}, "too slow to show inertia"),
    ("wrong unit of time", scaled(30, "time"), {}, "check the units of position, velocity and time"),
]


def write(folder, content):
    path = folder / "log.csv"
    if isinstance(content, dict):
        content = text(content)
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


@pytest.mark.slow
def test_what_cannot_be_read_is_reported_in_one_line_and_what_may_be_wrong_is_warned_of(tmp_path, file_regression):
    """The words of the table are in the message; all of it is as it was kept."""
    sound = describe(read_log(write(tmp_path, good()), Arm()), Arm()).facts
    said = [f"{label} {value}" for label, value in sound]
    for name, content, arm, found in REFUSED:
        with pytest.raises(InputError) as caught:
            uniform(read_log(write(tmp_path, content), Arm(**arm)))
        message = str(caught.value)
        assert found in message, name
        assert "\n" not in message, name
        assert "log.csv" in message or message.startswith("arm file: "), name
        assert len(message) < 400, name
        said.append(f"{name}: {message}")
    for name, content, keys, found in SUSPECTED:
        arm = Arm(**keys)
        log = describe(read_log(write(tmp_path, content), arm), arm)
        assert any(found in warning for warning in log.warnings), (name, log.warnings)
        assert not any("\n" in warning or len(warning) > 400 for warning in log.warnings), name
        facts = (f"{label} {value}" for label, value in log.facts if (label, value) not in sound)
        said += [f"{name}: {line}" for line in (*facts, *log.notes, *log.warnings)]
    kept = "\n".join(said).replace(str(tmp_path), "")
    file_regression.check(kept + "\n", check_fn=same, basename="messages")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("content", "found"),
    [
        pytest.param(content, found, id=name)
        for name, content, arm, found in SUSPECTED
        if found.startswith("with ") and not arm
    ],
)
def test_the_remedy_helps(tmp_path, content, found):
    path = write(tmp_path, content)
    (warning,) = (w for w in describe(read_log(path, Arm()), Arm()).warnings if found in w)
    remedy = warning.partition("write into the arm file: ")[2].partition(" (")[0].partition(" or ")[0]
    (tmp_path / "arm.yaml").write_text(remedy)
    arm = read_arm(tmp_path / "arm.yaml")
    after = describe(read_log(path, arm), arm).warnings
    assert not any("reads better" in w or "Eq. 1" in w or "velocity" in w for w in after)


def test_a_good_log_gives_no_warning(tmp_path):
    description = describe(read_log(write(tmp_path, good()), Arm()), Arm())
    assert description.warnings == ()


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(5))
def test_a_free_fall_is_no_other_reading(seed):
    """Torque that is noise about zero says nothing of units, signs or which joint is which."""
    rng = np.random.default_rng(seed)
    h, x, v, q = 0.002, rng.uniform(-2.5, 2.5, 2), np.zeros(2), []
    for _ in range(2500):
        q.append(x)
        v = v + h * forward_dynamics(x, v, np.zeros(2), BETA)
        x = x + h * v
    log = Log(name="fall.csv", t=h * np.arange(len(q)), q=np.array(q).T, tau=0.01 * rng.normal(size=(2, len(q))))
    warnings = diagnose(log, Arm())
    assert len(warnings) <= 1
    assert all("this log can only test the motion" in line for line in warnings)


@pytest.mark.parametrize(
    ("table", "named"),
    [
        (good(), None),
        (other_sign("tau1"), "torque_sign: [-1, 1]"),
        (absolute(), "second_joint_absolute: true"),
        (scaled(2, "q1", "dq1"), "multiply counts_per_turn by [2, 1]"),
    ],
)
def test_noise_of_the_torque_of_joint_2_hides_no_convention(table, named):
    table = {name: np.array(values) for name, values in table.items()}
    tau = np.stack([table["tau1"], table["tau2"] + 3.0 * np.std(table["tau2"]) * NOISE[1]])
    log = Log(name="log.csv", t=table["time"], q=np.stack([table["q1"], table["q2"]]), tau=tau)
    found = [warning for warning in diagnose(log, Arm()) if "reads better" in warning]
    assert len(found) == (named is not None)
    assert all(str(named) in warning for warning in found)


@pytest.mark.slow
@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_a_switched_torque_is_neither_noise_nor_saturated(noise):
    """A controller that only switches its torque: most of it is above any cutoff, and what is below drives the arm."""
    h, most, n = 0.002, np.array([8.0, 4.0]), 4000
    wanted, speed, _ = motion(h * np.arange(n))
    q, tau, x, v = np.empty((2, n)), np.empty((2, n)), wanted[:, 0], speed[:, 0]
    for k in range(n):
        q[:, k], tau[:, k] = x, most * np.sign(20.0 * (wanted[:, k] - x) + speed[:, k] - v)
        for _ in range(4):
            v = v + 0.25 * h * forward_dynamics(x, v, tau[:, k], BETA)
            x = x + 0.25 * h * v
    log = Log(
        name="log.csv", t=h * np.arange(n), q=q, tau=tau + noise * np.random.default_rng(2).normal(size=tau.shape)
    )
    assert diagnose(log, Arm()) == ()
    assert not torque_limits.saturated(log).any()


def test_foreign_headers_are_proposed_for_the_arm_file(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("Zeit,Schulter [deg],q2,M1,M2\n0,0,0,0,0\n", encoding="utf-8")
    with pytest.raises(InputError) as refused:
        read_log(path, Arm())
    skeleton = yaml.safe_load("columns:" + str(refused.value).rpartition("columns:")[2])
    assert skeleton["columns"] == {"time": "Zeit", "q1": "Schulter [deg]", "q2": "q2", "tau1": "M1", "tau2": "M2"}
