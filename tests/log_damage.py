"""The good log damaged in one way each: tables from header to values, or CSV text."""

import numpy as np
from log_example import columns, motion, recording, text

from repro.model.dynamics import inverse_dynamics

GOOD = columns(recording())
N = len(GOOD["time"])
DEGREE = np.pi / 180


def good():
    return {name: values.copy() for name, values in GOOD.items()}


def without(*names):
    return {name: values for name, values in good().items() if name not in names}


def renamed(**names):
    return {names.get(name, name): values for name, values in good().items()}


def scaled(factor, *names):
    return {name: values * (factor if name in names else 1.0) for name, values in good().items()}


def held(value, *names):
    """Constant columns; a velocity column goes with its position."""
    return {name: np.full(N, float(value)) if name in names else values for name, values in good().items()}


def cell(name, row, value):
    """One cell replaced; the header is line 1, so row 0 is line 2."""
    table = good()
    table[name] = [value if k == row else repr(float(x)) for k, x in enumerate(table[name])]
    return table


def rows(keep):
    return {name: values[keep] for name, values in good().items()}


def shifted(name, offset, begin, end=None):
    table = good()
    table[name][begin:end] += offset
    return table


def swapped(table, *pairs):
    """Columns exchanged."""
    other = dict(pairs) | {b: a for a, b in pairs}
    return {name: table[other.get(name, name)] for name in table}


def saturated(limit):
    table = good()
    table["tau1"] = np.clip(table["tau1"], -limit, limit)
    return table


def measured(q, dq, **changed):
    """The good torque with positions and velocities measured in another way."""
    r = recording()
    table = columns(r) | dict(zip(("q1", "q2", "dq1", "dq2"), (*q, *dq), strict=True)) | changed
    return {name: table[name] for name in GOOD}


def absolute():
    r = recording()
    return measured((r.q[0], r.q[0] + r.q[1]), (r.dq[0], r.dq[0] + r.dq[1]))


def offset(q1, q2):
    r = recording()
    return measured((r.q[0] + q1, r.q[1] + q2), r.dq)


def other_sign(*names):
    return scaled(-1.0, *names)


def slow_rate(seconds):
    """One sample in so many seconds of a longer recording."""
    return columns(recording(np.arange(0.0, 250 * seconds, seconds)))


def fast_motion():
    """A motion twelve times as fast, at the same rate."""
    pace = 12.0
    t = GOOD["time"]
    q, dq, ddq = motion(pace * t)
    q, dq, ddq = q * 3.0, dq * pace * 3.0, ddq * pace**2 * 3.0
    return dict(zip(GOOD, (t, *q, *dq, *inverse_dynamics(q, dq, ddq, np.full(9, 0.1))), strict=True))


def shifted_torque(seconds):
    """Torque recorded so much before it acts."""
    r = recording()
    return columns(r) | dict(zip(("tau1", "tau2"), recording(r.t + seconds).tau, strict=True))


def without_velocity(table):
    return {name: values for name, values in table.items() if not name.startswith("dq")}


def line_changed(change, number=100):
    """CSV text of the good log with one line changed."""
    lines = text(good()).splitlines()
    lines[number - 1] = change(lines[number - 1])
    return "\n".join(lines) + "\n"


def gaps(every):
    """A second missing in every so many seconds."""
    return rows(np.flatnonzero(GOOD["time"] % every < every - 1.0))


TIME_BACK = shifted("time", -0.02, 1000)
TWICE = good()
TWICE["time"][500] = TWICE["time"][499]
COARSE_TIME = good()
COARSE_TIME["time"] = np.round(COARSE_TIME["time"], 2)
NOISE = np.random.default_rng(5).standard_normal((2, N))
