"""The good log damaged in one way each: tables from header to values, CSV text, or bytes."""

import numpy as np
from log_example import columns, recording, text

GOOD = columns(recording())
N = len(GOOD["time"])
DEGREE = np.pi / 180
NOISE = np.random.default_rng(5).standard_normal((2, N))


def without(*names):
    return {name: values for name, values in GOOD.items() if name not in names}


def renamed(**names):
    return {names.get(name, name): values for name, values in GOOD.items()}


def replaced(signals, *names):
    return GOOD | dict(zip(names, signals, strict=True))


def scaled(factor, *names):
    return replaced([factor * GOOD[name] for name in names], *names)


def held(value, *names):
    return replaced(np.full((len(names), N), float(value)), *names)


def cell(name, row, value):
    """One cell replaced; the header is line 1, so row 0 is line 2."""
    return GOOD | {name: [value if k == row else repr(float(x)) for k, x in enumerate(GOOD[name])]}


def rows(keep):
    return {name: values[keep] for name, values in GOOD.items()}


def shifted(name, offset, begin, end=N):
    inside = (np.arange(N) >= begin) & (np.arange(N) < end)
    return GOOD | {name: GOOD[name] + offset * inside}


def swapped(*pairs):
    other = dict(pairs) | {b: a for a, b in pairs}
    return {name: GOOD[other.get(name, name)] for name in GOOD}


def saturated(limit):
    return GOOD | {"tau1": np.clip(GOOD["tau1"], -limit, limit)}


def absolute():
    return replaced([GOOD["q1"] + GOOD["q2"], GOOD["dq1"] + GOOD["dq2"]], "q2", "dq2")


def without_velocity(table):
    return {name: values for name, values in table.items() if not name.startswith("dq")}


def line_changed(change):
    """CSV text of the good log with line 100 changed."""
    lines = text(GOOD).splitlines()
    lines[99] = change(lines[99])
    return "\n".join(lines) + "\n"


#: Arm files that state the unit of a position: of an absurd one, and of one in counts of 1 rad.
RAD = {"units": {"position": "rad"}}
ABSOLUTE, BACKWARDS = {"second_joint_absolute": True}, {"sign": (-1.0, 1.0)}
COUNTS = {"units": {"position": "counts"}, "counts_per_turn": (2 * np.pi, 2 * np.pi)}

#: Name, content of the file (table, text or bytes), and keys of the arm, of logs that are refused.
REFUSED = [
    ("empty", b"", {}),
    ("blank lines only", "\n\n  \n", {}),
    ("header only", ",".join(GOOD) + "\n", {}),
    ("comments only", "# time\n# q1\n", {}),
    ("binary", bytes(range(256)) * 40, {}),
    ("spreadsheet", b"PK\x03\x04" + b"x" * 500, {}),
    ("UTF-16", text(GOOD).encode("utf-16"), {}),
    ("Latin-1", text(renamed(q1="q1 [°]")).encode("latin-1"), {}),
    ("prose", "Dear reader,\nthis is no log.\n", {}),
    ("one column", "time\n0\n1\n", {}),
    ("two separators", "time,s;state\n0,idle;1\n", {}),
    ("two decimal marks", text(cell("q1", 7, "1|5")).replace(",", ";").replace("|", ","), {}),
    ("decimals or groups", "time;q1;q2;tau1;tau2\n" + "0;1,234;1,234;1,234;1,234\n" * 300, {}),
    ("blanks in a name", text(renamed(q1="q1 [deg]")).replace(",", " "), {}),
    ("decimal commas", line_changed(lambda s: s.replace(".", ",")), {}),
    ("no header", text(GOOD).partition("\n")[2], {}),
    ("no header but empty cells", "0,NaN,1,2,3\n" * 300, {}),
    ("a column twice", text(GOOD).replace("dq2", "dq1", 1), {}),
    ("a row too long", line_changed(lambda s: s + ",1"), {}),
    ("a row too short", line_changed(lambda s: s.rpartition(",")[0]), {}),
    ("cut off", text(GOOD)[:-40], {}),
    ("text in a cell", cell("q2", 7, "broken"), {}),
    ("header twice", line_changed(lambda s: ",".join(GOOD)), {}),
    ("infinite", cell("tau2", 50, "-inf"), {}),
    ("too large", cell("q1", 50, "1e999"), {}),
    ("empty column", GOOD | {"tau2": ["NaN"] * N}, {}),
    ("digits in groups", cell("q1", 50, "1_000"), {}),
    ("clock time", cell("time", 0, "12:00:01.5"), {}),
    ("torque missing", without("tau1", "tau2"), {}),
    ("one position missing", without("q2"), {}),
    ("many columns", {**without("q2"), **{f"extra{k}": NOISE[0] for k in range(8)}}, {}),
    ("misspelt", renamed(tau1="tauu1"), {}),
    ("joints from 0", renamed(q1="q0", q2="q1"), {}),
    ("degrees without a unit", scaled(1 / DEGREE, "q1", "q2"), {}),
    ("a third joint", {**GOOD, "q0": GOOD["q1"], "tau0": GOOD["tau1"]}, {}),
    ("ambiguous", renamed(q1="q1 [rad]", dq1="pos1 [rad]"), {}),
    ("two units", renamed(q1="q1 [rad]", dq1="q1 [deg]"), {}),
    ("unknown unit", renamed(q1="q1 [grad]"), {}),
    ("unknown unit of a named column", renamed(tau1="Moment [kgm]"), {"columns": {"tau1": "Moment [kgm]"}}),
    ("a unit of something else", renamed(tau1="tau1 (rad)"), {}),
    ("counts of unknown size", renamed(q1="q1_counts", q2="q2_counts"), {}),
    ("current without a constant", renamed(tau1="current1", tau2="current2"), {}),
    ("PWM without a constant", renamed(tau1="tau1_Nm", tau2="pwm2"), {}),
    ("a constant without a current", GOOD, {"torque_constant": (2.0, 2.0)}),
    ("counts without a unit", GOOD, {"counts_per_turn": (4096.0, 4096.0)}),
    ("one unit of two", renamed(q1="q1 [deg]"), {}),
    ("a column not there", GOOD, {"columns": {"q1": "angle"}}),
    ("absurd position", cell("q1", 900, "-1e300"), RAD),
    ("absurd torque", cell("tau1", 900, "1e200"), {}),
    ("absurd time", cell("time", 2399, "1e300"), {}),
    ("a burst and a pause", rows(np.r_[:199, 2399]), {}),
    ("10 samples", rows(slice(10)), {}),
    ("1 s", rows(slice(250)), {}),
    ("backward time", shifted("time", -0.02, 1000), {}),
    ("the same time twice", shifted("time", -0.005, 500, 501), {}),
    ("coarse time", GOOD | {"time": np.round(GOOD["time"], 2)}, {}),
    ("constant time", held(1, "time"), {}),
    ("reversed", rows(slice(None, None, -1)), {}),
    ("milliseconds", scaled(1e3, "time"), {}),
    ("nanoseconds", scaled(1e9, "time"), {}),
    ("seconds for milliseconds", GOOD, {"units": {"time": "ms"}}),
    ("minutes", scaled(1 / 3600, "time"), {}),
    ("one sample a second", columns(recording(np.arange(250.0))), {}),
    ("gaps everywhere", rows(np.flatnonzero(GOOD["time"] % 1.5 < 0.5)), {}),
    ("an arm at rest", held(0.3, "q1", "q2"), {}),
    ("zero torque", held(0, "tau1", "tau2"), {}),
    ("constant torque", held(1.5, "tau2"), {}),
    ("saturated throughout", saturated(0.05), {}),
    ("beyond a known limit", GOOD, {"torque_limit": (0.05, 9.0)}),
    ("huge positions", cell("q1", N - 1, "1e308") | {"q2": cell("q2", 0, "-1e308")["q2"]}, {}),
    ("digits of another script", cell("q1", 0, "\u0661\u0662"), {}),
    ("tiny torques", scaled(1e-300, "tau1", "tau2"), {}),
    ("one tiny torque", scaled(1e-200, "tau2"), {}),
    ("a hundred thousand columns", ",".join(f"c{k}" for k in range(100_000)) + "\n" + "0," * 99_999 + "0\n", {}),
    ("a line without an end", "time,q1\n" + "1" * 3_000_000, {}),
]

#: The same of logs that are read with a warning.
SUSPECTED = [
    ("degrees", scaled(1 / DEGREE, "q1", "q2"), RAD),
    ("degrees, no velocity", without_velocity(scaled(1 / DEGREE, "q1", "q2")), RAD),
    ("degrees throughout", scaled(1 / DEGREE, "q1", "q2", "dq1", "dq2"), RAD),
    ("radians for degrees", GOOD, {"units": {"position": "deg"}}),
    ("velocity in deg/s", scaled(1 / DEGREE, "dq1", "dq2"), {}),
    ("velocity in rpm", scaled(30 / np.pi, "dq1", "dq2"), {}),
    ("velocity of the other sign", scaled(-1, "dq2"), {}),
    ("velocities swapped", swapped(("dq1", "dq2")), {}),
    ("velocity of something else", replaced(NOISE, "dq1", "dq2"), {}),
    ("velocity not filled in", held(0, "dq1", "dq2"), {}),
    ("velocity twice as large", scaled(2, "dq1"), {}),
    ("positions in counts", without_velocity(scaled(4096 / 2 / np.pi, "q1", "q2")), RAD),
    ("swapped joints", swapped(("q1", "q2"), ("dq1", "dq2"), ("tau1", "tau2")), {}),
    ("swapped torques", swapped(("tau1", "tau2")), {}),
    ("torque of the other sign", scaled(-1, "tau1", "tau2"), {}),
    ("torque 1 of the other sign", scaled(-1, "tau1"), {}),
    ("torque 2 of the other sign", scaled(-1, "tau2"), {}),
    ("joint 2 of the other sign", scaled(-1, "q2", "dq2", "tau2"), {}),
    ("absolute q2", absolute(), {}),
    ("q2 not absolute", GOOD, ABSOLUTE),
    ("q2 of the other sign", scaled(-1, "q2", "dq2"), {}),
    ("zero upright", shifted("q1", np.pi, 0), {}),
    ("zero horizontal", shifted("q1", np.pi / 2, 0), {}),
    ("zero horizontal, other side", shifted("q1", -np.pi / 2, 0), {}),
    ("both zeros upright", absolute() | {"q1": GOOD["q1"] + np.pi, "q2": absolute()["q2"] + np.pi}, ABSOLUTE),
    ("zero horizontal, counted backwards", scaled(-1, "q1", "dq1", "tau1") | {"q1": np.pi / 2 - GOOD["q1"]}, BACKWARDS),
    ("absolute q2 of the other sign", {key: x * (-1) ** key.endswith("2") for key, x in absolute().items()}, ABSOLUTE),
    ("zero folded back", shifted("q2", np.pi, 0), {}),
    ("both zeros half a turn off", GOOD | {name: GOOD[name] + np.pi for name in ("q1", "q2")}, {}),
    ("zero at a right angle", shifted("q2", np.pi / 2, 0), {}),
    ("q1 in half as many counts", scaled(2, "q1", "dq1"), COUNTS),
    ("q2 a quarter of the true one", scaled(0.25, "q2", "dq2"), {}),
    ("both half the true ones", scaled(0.5, "q1", "q2", "dq1", "dq2"), {}),
    ("torque of another arm", replaced(NOISE, "tau1", "tau2"), {}),
    ("torque recorded late", replaced(recording(GOOD["time"] - 0.12).tau, "tau1", "tau2"), {}),
    ("torque recorded early", replaced(recording(GOOD["time"] + 0.1).tau, "tau1", "tau2"), {}),
    ("torque in counts", replaced(np.rint(400 * recording().tau), "tau1", "tau2"), {}),
    ("torque in mN m", scaled(1e3, "tau1", "tau2"), {}),
    ("saturated", saturated(2.5), {}),
    ("beyond a known limit at times", GOOD, {"torque_limit": (2.5, 9.0)}),
    ("one joint still", held(0.2, "q2"), {}),
    ("position jumps", shifted("q1", 0.5, 1200), {}),
    ("a spike", shifted("q2", -2.0, 1200, 1201), {}),
    ("spikes of the torque", GOOD | {"tau1": np.where(np.arange(N) % 400 == 99, 60.0, GOOD["tau1"])}, {}),
    ("sampled too slowly", columns(recording(np.arange(250) / 10)), {}),
    ("much too slow", without_velocity(scaled(0.01, "q1", "q2")), {}),
    ("wrong unit of time", scaled(30, "time"), {}),
]
