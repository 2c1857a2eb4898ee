"""The public API: its names and signatures, the same numbers as the command, arrays and frames as files."""

import doctest
import inspect
import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pandas as pd
import pytest
from log_example import log_of, recording
from matplotlib.figure import Figure
from scipy.integrate import solve_ivp

import repro
from repro.cli import main
from repro.config.check import load_config
from repro.config.sections import data_settings, search_settings
from repro.experiments.arm import read_recording
from repro.experiments.identifications import identify_recording
from repro.identification.algorithm1.refinement import Algorithm1, RefinementSettings
from repro.model.dynamics import forward_dynamics

#: Parameters of each public function; a change breaks programs of users.
SIGNATURES = {
    "identify": "log, validate, arm, method, filter, cutoff, friction, prior, earlier, self_test, seed, steps, cache",
    "Identification": "details, method, _curves, _arm, _inputs, _load",
    "Log": "t, q, tau, dq, name, notes, simulated, torque_limit, breaks, left_out, block",
    "read_log": "source, arm",
    "read_arm": "path",
    "excite": "arm, duration, rate, harmonics, noise, guess, seed",
    "regressor": "q, dq, ddq, friction_steepness",
    "inverse_dynamics": "q, dq, ddq, beta, friction_steepness",
    "similarity": "x, y, settings",
    "low_pass": "x, h, c_f, unit",
    "differentiate": "x, h, c_f, unit",
    "images": "q, dq, ddq, tau, guess, settings",
    "load_network": "path, settings, fact, precision",
    "estimate_residuals": "network, images",
    "algorithm1": "q, tau, network, begin, end, signals, search_settings, seed",
    "SearchSettings": "executions, inner_limit, threshold, guess_low, guess_high, feasibility, image_motion, metric",
    "SignalSettings": "sampling_period_s, filter_coefficient, frequency_reading, image_samples, duration_s, "
    "normalise_motion",
    "read_capture": "path",
}
METHODS = "of, beta, parameters, errors, residuals, warnings, unusable, predict, simulate, plot, save"
LOG = "data/captures/T3.bin"


@pytest.fixture(scope="module")
def result():
    return repro.identify(LOG, validate=["data/captures/T2.bin"], method=["ordinary", "bounded"], seed=4)


def test_the_public_names_and_signatures_are_frozen():
    assert set(repro.__all__) == {*SIGNATURES, "Arm", "InputError"}
    for name, parameters in SIGNATURES.items():
        assert ", ".join(inspect.signature(getattr(repro, name)).parameters) == parameters, name
    assert all(hasattr(repro.Identification, name) for name in METHODS.split(", "))
    assert inspect.signature(repro.identify).parameters["method"].default == "weighted-consistent"
    with pytest.raises(AttributeError):
        repro.nothing  # noqa: B018


@pytest.mark.parametrize("name", sorted(repro.__all__))
def test_examples_of_the_docstrings(name):
    thing = getattr(repro, name)
    scope = {"np": np, "Path": Path, "repro": repro}  # what docs/api.md states
    (docstring,) = doctest.DocTestFinder(recurse=False).find(thing, name, globs=scope)
    assert docstring.examples or name.endswith("Settings")
    assert doctest.DocTestRunner().run(docstring).failed == 0


@pytest.mark.parametrize(
    ("work", "modules"),
    [
        ("import repro", "numpy torch pandas"),
        ("import repro.cli; repro.cli.parser()", "torch pandas scipy serial"),
        (f"import repro; repro.identify({LOG!r}, method='ordinary')", "torch snakemake"),
    ],
    ids=["import", "help", "least squares"],
)
def test_what_needs_no_heavy_library_loads_none(work, modules):
    code = f"{work}; import sys; print({{*{modules.split()}}} & sys.modules.keys())"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "set()\n"


def test_the_command_prints_the_same_digits(result, tmp_path, no_figures):
    options = ["--method", "ordinary", "--method", "bounded", "--seed", "4", "-o", str(tmp_path / "out")]
    assert main(["identify", LOG, "--validate", "data/captures/T2.bin", *options]) == 0
    content = json.loads((tmp_path / "out/parameters.json").read_text(encoding="utf-8"))
    assert content["recommended"] == result.method
    for method in content["methods"]:
        own = result.of(method["method"]).parameters
        assert [p["estimate"] for p in method["parameters"]] == own["estimate"].tolist()
        assert [p["low"] for p in method["parameters"]] == [None if np.isnan(x) else x for x in own["low"]]
        assert [p["verdict"] for p in method["parameters"]] == own["verdict"].tolist()
    files = result.save(tmp_path / "saved")
    assert sorted(files) == sorted(path.name for path in (tmp_path / "out").iterdir())
    for name in set(files) - {"provenance.json"}:
        assert (tmp_path / "saved" / name).read_bytes() == (tmp_path / "out" / name).read_bytes(), name
    with pytest.raises(repro.InputError):
        result.save(tmp_path / "saved")


def table_of(t, q, tau):
    return pd.DataFrame({"time": t, "q1": q[0], "q2": q[1], "tau1": tau[0], "tau2": tau[1]})


def test_strict_refuses_what_must_not_be_used(tmp_path, capsys, no_figures):
    log = repro.read_log(LOG).piece(0, 3000)
    table_of(log.t, log.q, -log.tau).to_csv(tmp_path / "log.csv", index=False)
    options = ["--method", "ordinary", "-o", str(tmp_path / "out"), "--overwrite"]
    assert main(["identify", str(tmp_path / "log.csv"), *options]) == 0
    assert main(["identify", str(tmp_path / "log.csv"), *options, "--strict"]) == 3
    assert capsys.readouterr().out.splitlines()[-1].startswith("--strict: ")
    assert main(["identify", LOG, "--method", "consistent", "-o", str(tmp_path / "good"), "--strict"]) == 0


def test_a_result_that_nobody_reads_is_written(tmp_path, monkeypatch, capsys, no_figures):
    monkeypatch.setattr("builtins.print", Mock(side_effect=BrokenPipeError))  # as after `| head -1`
    assert main(["identify", LOG, "--method", "bounded", "-o", str(tmp_path / "out")]) == 1
    assert (tmp_path / "out" / "parameters.json").exists()


def test_arrays_and_frames_give_the_numbers_of_a_file(tmp_path):
    log = repro.read_log(LOG).piece(0, 3000)
    frame = table_of(log.t, log.q, log.tau)
    frame.to_csv(tmp_path / "log.csv", index=False)
    given = (tmp_path / "log.csv", frame, repro.Log(t=log.t, q=log.q, tau=log.tau))
    file, table, arrays = (repro.identify(one, method="ordinary").beta for one in given)
    assert file.tolist() == table.tolist() == arrays.tolist()


def test_a_turned_arm_is_read_by_its_conventions(tmp_path):
    log = repro.read_log(LOG)
    arm = repro.Arm(zero=(0.3, -0.2), sign=(1.0, -1.0))
    turned = repro.Log(t=log.t, q=log.q * [[1.0], [-1.0]] + [[0.3], [-0.2]], tau=log.tau * [[1.0], [-1.0]])
    (tmp_path / "arm.yaml").write_text("{zero: [0.3, -0.2], sign: [1, -1]}")
    for described in (arm, tmp_path / "arm.yaml", str(tmp_path / "arm.yaml")):
        assert repro.read_log(turned, described).q == pytest.approx(log.q, abs=1e-12)


def test_warnings_contain_those_of_the_log():
    log = repro.read_log(LOG)
    in_degrees = repro.Log(t=log.t, q=np.degrees(log.q), tau=log.tau)
    warnings = repro.identify(in_degrees, method="ordinary").warnings
    assert any("units: {position: deg}" in warning for warning in warnings)


@pytest.mark.parametrize(
    ("change", "place"),
    [({"t": np.arange(2502.0) / 1e6}, "T3.bin: time"), ({"tau": np.zeros((2, 2502))}, "T3.bin: torque of joint 1")],
)
def test_arrays_that_are_no_recording_are_refused(change, place):
    with pytest.raises(repro.InputError, match=f"^{place}: found "):
        repro.identify(replace(repro.read_log(LOG), **change))


@pytest.mark.parametrize(
    ("change", "place"),
    [
        ({"q": np.zeros((4, 2))}, "log: q"),
        ({"q": [[1.0, 2.0], [3.0]]}, "log: q"),
        ({"t": ["0", "1", "2", "3"]}, "log: t"),
        ({"t": [0.0, 1.0, 1.0, 2.0]}, r"log: t\[2\]"),
        ({"tau": np.zeros((2, 4), bool)}, "log: tau"),
        ({"tau": np.zeros((2, 4)) * 1j}, "log: tau"),
        ({"q": np.ma.masked_less(np.zeros((2, 4)), 1.0)}, "log: q"),
        ({"q": [[0.0, 0.0, np.nan, 0.0], [0.0] * 4]}, "log: q"),
        ({"dq": np.full((2, 4), np.inf)}, "log: dq"),
        ({"torque_limit": [1.0]}, "log: torque_limit"),
        ({"torque_limit": [0.0, 1.0]}, "log: torque_limit"),
        ({"breaks": (9,)}, "log: breaks"),
        ({"notes": "one"}, "log: notes"),
        ({"name": 5}, "name"),
    ],
)
def test_a_log_of_arrays_is_checked_at_once(change, place):
    arrays = {"t": np.arange(4.0), "q": np.zeros((2, 4)), "tau": np.zeros((2, 4))}
    assert repro.Log(**arrays).q.shape == (2, 4)
    with pytest.raises(repro.InputError, match=f"^{place}: found "):
        repro.Log(**arrays | change)


@pytest.mark.parametrize(
    ("options", "place"),
    [
        ({"method": "bayes"}, "method"),
        ({"method": []}, "method"),
        ({"method": 5}, "method"),
        ({"method": {"ordinary"}}, "method: found"),
        ({"filter": "fir"}, "filter"),
        ({"cutoff": "5 Hz"}, "cutoff"),
        ({"cutoff": float("nan")}, "cutoff"),
        ({"cutoff": True}, "cutoff"),
        ({"cutoff": -1}, "cutoff"),
        ({"seed": "x"}, "seed"),
        ({"seed": -3}, "seed"),
        ({"steps": 2.5}, "steps"),
        ({"method": "algorithm1", "self_test": True}, "self_test"),
        ({"validate": LOG}, "validate: "),
        ({"arm": "gone.yaml"}, "gone.yaml"),
        ({"arm": {"zero": (0.0, 0.0)}}, "arm: found"),
        ({"cache": 5}, "cache: found"),
        ({"cache": "~nosuchuser/x"}, "cache: ~nosuchuser/x: found no such user"),
        ({"filter": ["dct"]}, "filter: found"),
        ({"validate": 5}, "validate: found"),
        ({"validate": [None]}, "validate: found"),
    ],
)
def test_wrong_options_are_refused_by_name(options, place):
    with pytest.raises(repro.InputError, match=f"^{place}"):
        repro.identify(LOG, **options)


def test_networks_are_kept_where_the_user_says(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    with pytest.raises(repro.InputError, match=r"^cache: "):
        (tmp_path / "cache").write_text("no folder")
        repro.identify(LOG, method="algorithm1", steps=1)


def test_a_simulated_log_that_only_validates_marks_the_result():
    run = recording(np.arange(0.0, 20.0, 0.01))
    result = repro.identify(log_of(run), validate="data/captures/T2.bin", method="ordinary")
    assert str(result).startswith("arm (simulated): ")


def test_tables_and_drawing_of_a_result(result, tmp_path):
    assert list(result.parameters.index) == ["I1", "I2", "I3", "g1", "g2", "b1", "b2", "k1", "k2"]
    assert set(result.errors["part"]) == {"fit", "half", "validation"}
    assert set(result.residuals["log"]) == {"T3.bin", "T2.bin"}
    residual = result.residuals["torque_nm"] - result.residuals["rebuilt_nm"]
    assert residual.to_numpy() == pytest.approx(result.residuals["residual_nm"].to_numpy())
    assert (result.of("ordinary").residuals["rebuilt_nm"] != result.of("bounded").residuals["rebuilt_nm"]).any()
    assert isinstance(result.plot(-1), Figure)
    assert "simulated" in result._repr_html_()
    named = replace(result, details=replace(result.details, arm="<i>", warnings=("<b>.csv: slow",)))
    assert "<b>&lt;i&gt;" in named._repr_html_()
    assert "<li>&lt;b&gt;.csv: slow</li>" in named._repr_html_()
    assert str(result.of("bounded")).startswith("arm (simulated): bounded")
    made = result.details.methods
    methods = [replace(m, consistent=m.method != "bounded", why_not_consistent="b1 < 0") for m in made]
    spoilt = replace(result, details=replace(result.details, methods=tuple(methods)))
    assert not spoilt.of("ordinary").unusable and spoilt.of("bounded").unusable.endswith("b1 < 0")
    for call, place in (
        (lambda: result.of("robust"), "method"),
        (lambda: result.plot(7), "log: found 7"),
        (lambda: result.of("bounded").save(tmp_path / "out"), "method: found 'bounded'"),
        (lambda: result.save(tmp_path / "out", overwrite="no"), "overwrite: found 'no'"),
        (lambda: result.save(None), "folder: found None"),
    ):
        with pytest.raises(repro.InputError, match=f"^{place}"):
            call()
    assert not (tmp_path / "out").exists()


def test_simulation_agrees_with_an_independent_integrator(result):
    own, t, steepness = result.of("bounded"), np.linspace(0.0, 0.4, 33), 4.0
    tau = np.stack([0.6 * np.sin(7.0 * t), 0.2 * np.cos(5.0 * t)])
    preparation = replace(own.details.preparation, friction_steepness=steepness)
    own = replace(own, details=replace(own.details, preparation=preparation, friction=()))

    def derivative(at, state):
        torque = np.array([np.interp(at, t, joint) for joint in tau])
        return np.concatenate([state[2:], forward_dynamics(state[:2], state[2:], torque, own.beta, steepness)])

    solved = solve_ivp(derivative, (0.0, 0.4), [0.4, -0.3, 0.0, 0.5], t_eval=t, rtol=1e-9, atol=1e-11, max_step=1e-3)
    q, dq = own.simulate(t, tau, [0.4, -0.3], [0.0, 0.5])
    assert q == pytest.approx(solved.y[:2], abs=2e-4)
    assert dq == pytest.approx(solved.y[2:], abs=1e-3)
    ddq = forward_dynamics(q.T, dq.T, tau.T, own.beta, steepness).T
    assert own.predict(q, dq, ddq) == pytest.approx(tau)
    for wrong in (t[::-1], np.r_[t[:-1], t[-2]]):
        with pytest.raises(ValueError, match=r"^t: "):
            own.simulate(wrong, tau, [0.0, 0.0], [0.0, 0.0])
    with pytest.raises(ValueError, match=r"^t, tau, q0, dq0: "):
        own.simulate(t, tau[:, 1:], [0.0, 0.0], [0.0, 0.0])


def test_errors_name_the_arguments_of_the_public_functions():
    signal = np.ones((2, 40))
    with pytest.raises(ValueError, match=r"^guess: "):
        repro.images(signal, signal, signal, signal, np.ones(8))
    network = repro.load_network("data/networks/cnn.safetensors")
    for wrong in (np.ones((100, 100)), np.ones((2, 99, 100)), np.full((2, 100, 100), np.nan)):
        with pytest.raises(ValueError, match=r"^images: "):
            repro.estimate_residuals(network, wrong)
    for steepness in (-3, 0):
        with pytest.raises(ValueError, match=r"^friction_steepness: "):
            repro.inverse_dynamics(signal, signal, signal, np.ones(9), friction_steepness=steepness)
    with pytest.raises(ValueError, match=r"^begin, end: "):
        repro.algorithm1(np.ones((2, 400)), np.ones((2, 400)), None, begin=300, end=10)
    choice = {"image_motion": "x"}
    for wrong in ({"executions": 0}, {"inner_limit": 2.5}, {"threshold": 92.37}, {"guess_low": 4.0}, choice):
        with pytest.raises(ValueError, match=f"^{next(iter(wrong))}"):
            repro.SearchSettings(**wrong)
    period, other = {"sampling_period_s": "x"}, {"frequency_reading": "rpm"}
    for wrong in (period, {"filter_coefficient": -1e-4}, {"image_samples": 2.5}, {"duration_s": np.inf}, other):
        with pytest.raises(repro.InputError, match=f"^{next(iter(wrong))}: found .*, expected "):
            repro.SignalSettings(**wrong)
    arm = repro.Arm(position_limit=((-1.0, 1.0), (-2.0, 2.0)), speed_limit=(3.0, 4.0))
    guesses = ("parameters.json", [np.ones(9)] * 2, [0.1, 0.0, -0.05, *np.ones(6)])
    wrongs = [{"rate": "100"}, {"duration": float("nan")}, {"harmonics": 4.5}, {"noise": (0.05, 0.0)}, {"seed": "x"}]
    for wrong in (*wrongs, *({"guess": guess} for guess in guesses)):
        with pytest.raises(repro.InputError, match=f"^{next(iter(wrong))}: found "):
            repro.excite(arm, **wrong)
    with pytest.raises(repro.InputError, match=r"^precision: found 'float64'"):
        repro.load_network("data/networks/cnn.safetensors", precision="float64")
    for call in (lambda: repro.read_log({}), lambda: repro.excite({})):
        with pytest.raises(repro.InputError, match=r"^(source|arm): found dict"):
            call()


def test_lists_are_as_good_as_arrays(result):
    t, q, tau = [0.0, 0.1, 0.2], [[0.1, 0.2, 0.4], [0.0, 0.1, 0.3]], [[0, 0, 0], [0, 0, 0]]
    assert np.array_equal(result.predict(q, q, q), result.predict(*(np.array(q),) * 3))
    arrays = np.array(t), np.zeros((2, 3)), np.zeros(2), np.array([0.0, 1.0])
    assert np.array_equal(result.simulate(t, tau, [0, 0], [0, 1]), result.simulate(*arrays))
    assert np.array_equal(repro.low_pass(q, 0.1, 1e-4), repro.low_pass(np.array(q), 0.1, 1e-4))
    assert np.array_equal(repro.regressor(q, q, q), repro.regressor(*(np.array(q),) * 3))
    with pytest.raises(ValueError, match="finite"):
        result.simulate(t, tau, [0, np.nan], [0, 0])
    arm = repro.Arm(zero=[1, 0], torque_limit=np.array([1, 2]), delay="auto")
    assert (arm.zero, arm.torque_limit, arm.delay) == ((1.0, 0.0), (1.0, 2.0), None)


@pytest.mark.parametrize("longer", [0, -500])  # than Eq. 10: time runs in another scale
def test_algorithm1_gives_the_numbers_of_the_workflow(longer):
    config = load_config(Path("config/config.yaml"))
    recording = read_recording(Path("data/captures/ID.bin"), config)
    program = replace(recording.program, n2=recording.program.n2 + longer)
    recording, signals = replace(recording, program=program), config.signals
    network = repro.load_network("data/networks/cnn.safetensors")
    few = replace(search_settings(config), executions=3, inner_limit=4, threshold=0.9)
    algorithm1 = Algorithm1("published", network, data_settings(config).image, few, RefinementSettings(passes=0))
    level = np.ones((2, round(signals.duration_s / signals.sampling_period_s)))  # cancels in line 32
    run = identify_recording(algorithm1, recording, level, signals, 5, np.zeros(9))
    part = {"begin": program.n1, "end": program.n2}
    found = repro.algorithm1(recording.q, recording.tau, network, **part, search_settings=few, seed=5)
    assert found.beta == pytest.approx(run["arms"]["ID"]["methods"]["algorithm1"]["beta"], rel=1e-9)
    assert found.similarity == pytest.approx(run["arms"]["ID"]["methods"]["algorithm1"]["similarity"])
