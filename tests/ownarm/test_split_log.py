"""A log with gaps: all its pieces make one fit, with one cut-off, delay and zero, and filters see no gap."""

from dataclasses import replace

import numpy as np
import pytest
from log_example import BETA, columns, motion, recording, text
from ownarm_problem import ARM, solved

from repro.identification.filtering import FilterSettings, prepare
from repro.logs.log import Log, uniform
from repro.ownarm.figures import draw_overlay
from repro.ownarm.prepare import Options, load_log
from repro.ownarm.problem import make_problem

OPTIONS = Options(("ordinary",), "unused")
T = np.arange(6000) / 200.0
#: Delay of the torque, s, and what the zero of joint 1 is off by, rad.
DELAY, ZERO = 0.005, 0.08


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """30 s: cells empty for 1 s, 3.5 s never written, and a piece of 1 s between two gaps."""
    rng = np.random.default_rng(0)
    r = recording(T)
    tau = recording(T + DELAY).tau + 0.02 * rng.normal(size=(2, T.size))
    table = columns(replace(r, q=r.q + np.array([[ZERO], [0.0]]), tau=tau))
    table["tau2"] = ["NaN" if 9.0 <= t < 10.0 else f"{x:.9g}" for t, x in zip(T, table["tau2"], strict=True)]
    keep = np.flatnonzero((T < 18.0) | ((T >= 19.5) & (T < 20.5)) | (T >= 21.5))
    path = tmp_path_factory.mktemp("split") / "split.csv"
    path.write_text(text({name: [column[k] for k in keep] for name, column in table.items()}), encoding="utf-8")
    log = load_log(path, ARM)
    problem = make_problem((log,), (), ARM, OPTIONS)
    return problem, *solved(problem)


def test_one_delay_one_zero_and_the_parameters_of_all_pieces(whole):
    problem, result, _ = whole
    (log,) = problem.logs
    assert log.settings.delay == pytest.approx(DELAY, abs=1e-3)
    assert [fault.name for fault in log.faults] == ["zero1"]
    assert log.faults[0].value == pytest.approx(-ZERO, abs=0.005)
    (method,) = result.methods
    assert [parameter.estimate for parameter in method.parameters][:5] == pytest.approx(BETA[:5], rel=0.03)
    assert max(method.fit.relative_rms) < 0.02
    assert max(method.fit.position_rms) < 0.02
    seconds = problem.regression.t.size * problem.regression.h
    assert seconds == pytest.approx(8.995 + 7.995 + 8.495 - 3 * 0.6, abs=0.5)


def test_each_piece_is_filtered_as_if_it_were_alone():
    r = recording(T)
    keep = (T < 11.0) | (T > 13.0)
    log = uniform(Log(name="log.csv", t=T[keep], q=r.q[:, keep], tau=r.tau[:, keep]))
    both, parts = prepare(log, FilterSettings()), [prepare(piece, FilterSettings()) for piece in log.pieces]
    for name in ("y", "tau", "q", "dq", "ddq"):
        together = np.concatenate([getattr(part, name) for part in parts], axis=1)
        np.testing.assert_array_equal(getattr(both, name), together)
    np.testing.assert_array_equal(both.even_odd, np.concatenate([part.even_odd for part in parts], axis=2))
    np.testing.assert_allclose(both.q, motion(both.t)[0], atol=0.01)  # times are those of the log
    error = both.tau - both.y @ BETA
    assert np.abs(error).max() < 0.03 * np.abs(both.tau).max()


def test_no_line_is_drawn_across_a_gap(whole):
    _, _, curves = whole
    figure = draw_overlay(curves.signals[0], {"ordinary": "Ordinary"})
    for axes in figure.axes[::2]:
        for line in axes.lines:
            x, y = line.get_data()
            drawn = ~np.isnan(y)
            assert not np.any(drawn[1:] & drawn[:-1] & (np.diff(x) > 0.5))
    assert all(np.isfinite(line.get_ydata()).sum() > 10 for axes in figure.axes for line in axes.lines)
