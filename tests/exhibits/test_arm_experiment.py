"""Numbers of Figures 18 to 24 and Tables 8 to 10 from short recordings whose results are known."""

from pathlib import Path

import numpy as np
import pytest
from experiment_example import (
    CROSSED,
    ERROR,
    LEAST_SQUARES,
    MEDIAN,
    MOTIONS,
    experiment_inputs,
    full_config,
    identification,
    least_squares_run,
    recording,
    score_table,
    short_config,
)

from repro.exhibits import arm_experiment, schematics
from repro.exhibits.arm_experiment import (
    HIGHEST,
    control_table,
    identification_curves,
    motion_curves,
    shown_estimates,
    stability_table,
    tip_paths,
    validation_curves,
)
from repro.identification.algorithm1.preprocessing import prepare
from repro.model.dynamics import inverse_dynamics
from repro.model.parameters import is_positive_definite
from repro.model.stability import stability_constants
from repro.pipeline.experiment import (
    control_constants,
    mechanical_parameters,
    program_settings,
    read_recording,
    true_parameters,
)
from repro.pipeline.experiment_runs import every_seed, least_squares_of, score_runs, tracking
from repro.settings import metric_settings, signal_settings

CONFIG = short_config()
TRUE = true_parameters(CONFIG)
SIGNALS = signal_settings(CONFIG)
RUNS = [*(identification(seed, TRUE) for seed in ERROR), least_squares_run(TRUE)]
ESTIMATES = {"algorithm1": 0.9 * TRUE, "algorithm1+refinement": 1.03 * TRUE, "least-squares": 1.1 * TRUE, "true": TRUE}
H = 0.0025


@pytest.fixture(scope="module")
def recordings():
    return {motion: recording(motion, CONFIG) for motion in MOTIONS}


@pytest.fixture(scope="module")
def inputs(tmp_path_factory):
    return experiment_inputs(tmp_path_factory.mktemp("experiment"), CONFIG)


def curve(frame, panel, series):
    rows = frame[(frame["panel"] == panel) & (frame["series"] == series)]
    assert len(rows), (panel, series)
    return rows["x"].to_numpy(), rows["y"].to_numpy()


def test_every_seed_has_a_part_in_what_has_no_seed_of_its_own():
    runs = every_seed(RUNS)
    assert [run["seed"] for run in runs] == [1, 2, 3, 1, 2, 3]
    for run in runs[3:]:
        assert set(run["arms"]["ID"]["methods"]) == {"least-squares", "bounded", "consistent", "true"}
        assert run["arms"] == RUNS[-1]["arms"]
    assert runs[:3] == RUNS[:3]
    assert [run["seed"] for run in every_seed(RUNS[-1:])] == [0]
    assert RUNS[-1]["seed"] == 0  # as it was


@pytest.mark.parametrize("order", [1, -1])
def test_the_seed_that_stands_for_a_method_is_the_median_one_on_id(order):
    runs = every_seed(RUNS)[::order]
    scores = score_table(runs)
    worse = scores["case"] != "ID"
    scores.loc[worse, "total"] = 1.0 - scores.loc[worse, "total"]  # what other motions say does not count
    shown = shown_estimates(runs, scores)
    field = {"least-squares", "bounded", "consistent"}
    assert set(shown) == {"algorithm1", "algorithm1+refinement", "algorithm1+local-search", *field, "true"}
    np.testing.assert_allclose(shown["algorithm1"], ERROR[MEDIAN] * TRUE)
    np.testing.assert_allclose(shown["algorithm1+refinement"], (1 + 0.01 * MEDIAN) * TRUE)
    np.testing.assert_allclose(shown["least-squares"], LEAST_SQUARES * TRUE)
    np.testing.assert_array_equal(shown["true"], TRUE)


def test_figure_19_shows_torques_of_the_trajectory_proper_and_the_motion(recordings):
    frame = identification_curves(recordings["ID"], SIGNALS, ESTIMATES)
    program, n = recordings["ID"].program, 2400
    for joint in (1, 2):
        x, measured = curve(frame, f"torque{joint}", "measured")
        assert x.size == n
        np.testing.assert_allclose(x, H * np.arange(n), atol=1e-9)
        truth = inverse_dynamics(program.q, *_derivatives(program.q), TRUE)[joint - 1, program.n1 : program.n2]
        assert np.linalg.norm(measured - truth) < 0.1 * np.linalg.norm(truth)
        _, fitted = curve(frame, f"torque{joint}", "algorithm1")
        _, higher = curve(frame, f"torque{joint}", "least-squares")
        np.testing.assert_allclose(higher * 0.9, fitted * 1.1, rtol=1e-9)
        _, desired = curve(frame, "position", f"desired{joint}")
        np.testing.assert_array_equal(desired, program.q[joint - 1, program.n1 : program.n2])
        _, actual = curve(frame, "position", f"joint{joint}")
        assert np.abs(actual - desired).max() < 1e-3
        for panel, exact in zip(("velocity", "acceleration"), _derivatives(program.q), strict=True):
            _, found = curve(frame, panel, f"joint{joint}")
            assert np.abs(found - exact[joint - 1, program.n1 : program.n2]).max() < 0.1 * np.abs(exact).max()
    torques = frame[frame["panel"].str.startswith("torque")]
    assert set(torques["series"]) == {"measured", "algorithm1", "algorithm1+refinement", "least-squares"}


def _derivatives(q):
    dq = np.gradient(q, H, axis=1)
    return dq, np.gradient(dq, H, axis=1)


@pytest.mark.parametrize("motion", ["ID", "T4"])
def test_spectra_are_those_of_the_curves_over_frequency_in_hertz(recordings, motion):
    if motion == "ID":
        draw, prefix = (lambda spectra: identification_curves(recordings["ID"], SIGNALS, ESTIMATES, spectra)), ""
    else:
        draw, prefix = (lambda spectra: validation_curves([recordings["T4"]], SIGNALS, ESTIMATES, spectra)), "T4 "
    in_time, in_frequency = draw(False), draw(True)
    for joint in (1, 2):
        for series in ("measured", "least-squares"):
            _, tau = curve(in_time, f"{prefix}torque{joint}", series)
            frequency, spectrum = curve(in_frequency, f"{prefix}torque{joint}", series)
            n = tau.size
            k = np.arange(n)
            bands = [np.sum(tau * np.cos(np.pi * j * (2 * k + 1) / (2 * n))) * np.sqrt(2 / n) for j in (1, 7, 30)]
            np.testing.assert_allclose(np.abs(spectrum[[1, 7, 30]]), np.abs(bands), atol=1e-9 * np.abs(spectrum).max())
            np.testing.assert_allclose(frequency, k[: frequency.size] / (2 * n * H), atol=1e-9)
            assert frequency[-1] <= HIGHEST < frequency[-1] + 1 / (2 * n * H)
    assert set(in_frequency["panel"]) == {f"{prefix}torque1", f"{prefix}torque2"}


def test_figure_21_is_where_the_tip_was_and_should_have_been(recordings):
    geometry = program_settings(CONFIG).geometry
    frame = tip_paths([recordings["T2"], recordings["T4"]], geometry)
    for motion in ("T2", "T4"):
        for series, q in (("desired", recordings[motion].program.q), ("actual", recordings[motion].q)):
            x, y = curve(frame, motion, series)
            total = q[0] + q[1]
            np.testing.assert_allclose(x, 0.165 * np.sin(q[0]) + 0.150 * np.sin(total), atol=1e-12)
            np.testing.assert_allclose(y, -0.165 * np.cos(q[0]) - 0.150 * np.cos(total), atol=1e-12)


def test_figure_22_shows_each_motion_in_panels_of_its_own(recordings):
    frame = motion_curves([recordings[motion] for motion in MOTIONS[1:]], SIGNALS)
    panels = {f"{motion} {panel}" for motion in MOTIONS[1:] for panel in ("position", "velocity", "acceleration")}
    assert set(frame["panel"]) == panels
    for motion in MOTIONS[1:]:
        _, desired = curve(frame, f"{motion} position", "desired1")
        np.testing.assert_array_equal(desired, recordings[motion].program.q[0])


def test_figures_23_and_24_show_the_two_methods_that_are_compared(inputs):
    for name in ("fig23", "fig24"):
        frame = getattr(arm_experiment, name).numbers(inputs[name], CONFIG)
        assert set(frame["panel"]) == {f"{motion} torque{j}" for motion in MOTIONS[1:] for j in (1, 2)}
        assert set(frame["series"]) == {"measured", "algorithm1+refinement", "least-squares"}
        _, refined = curve(frame, "T1 torque1", "algorithm1+refinement")
        _, least = curve(frame, "T1 torque1", "least-squares")
        np.testing.assert_allclose(refined * LEAST_SQUARES, least * (1 + 0.01 * MEDIAN), rtol=1e-6, atol=1e-9)


def test_figure_18_tells_the_configuration():
    frame = schematics.fig18.numbers({}, CONFIG).set_index(["component", "label"])
    assert frame["value"]["arm", "l1"] == "0.165"
    assert frame["value"]["uplink", "-"].tolist() == ["64 bit", "400"]
    assert frame["value"]["motors", "joint 1"] == "8/1023"
    assert frame["value"]["ram", "-"] == "8192 x 2"


def test_table_8_has_the_tracking_and_the_constants(recordings):
    tracked = tracking(recordings["ID"], metric_settings(CONFIG))
    table = control_table(tracked, control_constants(CONFIG), 1e-4)
    assert table["joint"].tolist() == [1, 2]
    assert (table["total"] > 0.995).all()  # a perfect run, but for the rounding to counts
    np.testing.assert_allclose(table["total"], table["time"] * table["frequency"])
    assert table["kp"].tolist() == [180.4817, 30.6819]
    assert table["kv"].tolist() == [1270.7266, 102.2730]
    assert table["pwm_khz"].tolist() == [1.0, 1.0]
    assert table["c_f"].tolist() == [1e-4, 1e-4]


def test_table_9_has_the_median_seed_and_no_row_for_the_truth(inputs):
    table = arm_experiment.table09.numbers(inputs["table09"], CONFIG)
    assert "true" not in set(table["method"])
    assert set(table["case"]) == {"ID"}
    for method, factor in {"algorithm1": ERROR[MEDIAN], "least-squares": LEAST_SQUARES}.items():
        rows = table[table["method"] == method]
        np.testing.assert_allclose(rows["true"], TRUE)
        np.testing.assert_allclose(rows["estimate"], factor * TRUE)
    sd = table[table["method"] == "algorithm1"]["estimate_sd"]
    np.testing.assert_allclose(sd, np.std(list(ERROR.values()), ddof=1) * TRUE)
    assert (table[table["method"] == "least-squares"]["estimate_sd"] < 1e-15).all()


def test_table_10_has_every_motion_method_and_joint(inputs):
    table = arm_experiment.table10.numbers(inputs["table10"], CONFIG)
    methods = {"algorithm1", "algorithm1+refinement", "algorithm1+local-search"}
    methods |= {f"algorithm1{suffix}" for suffix in CROSSED} | {"least-squares", "bounded", "consistent", "true"}
    one_run = table["method"].str.endswith("/one-run")
    assert set(table.loc[~one_run, "method"]) == methods
    assert set(table.loc[one_run, "method"]) == {"algorithm1/one-run", "algorithm1+tracked/one-run"}
    assert len(table) == 5 * (len(methods) + 2) * 2
    assert (table.loc[~one_run, "seeds"] == 3).all()
    assert (table.loc[one_run, "seeds"] == 1).all()
    np.testing.assert_allclose(table["total"], table["time"] * table["frequency"])


def test_the_stability_table_has_the_four_conditions_of_each_method(inputs):
    table = arm_experiment.stability.numbers(inputs["stability"], CONFIG)
    assert table["method"].drop_duplicates().tolist() == [
        "algorithm1", "algorithm1+refinement", "least-squares", "true", "appendix",
    ]  # fmt: skip
    assert (table.groupby("method").size() == 4).all()
    for method, beta in (("true", TRUE), ("appendix", mechanical_parameters(CONFIG))):
        rows, expected = table[table["method"] == method], stability_constants(beta)
        assert rows["value"].tolist() == [expected.potential, expected.energy, expected.dissipation, expected.r1_min]
        assert rows["bound"].tolist() == [0.0, 0.0, expected.coupling, expected.r2_max]
    assert (table["holds"] == (table["value"] > table["bound"])).all()
    assert table.loc[table["method"] == "appendix", "holds"].all()


def test_conditions_that_do_not_hold_are_told():
    slack = TRUE.copy()
    slack[7:] = 1e-9
    slack[5:7] = 1e-9
    table = stability_table({"true": slack}, ["true"]).set_index("quantity")
    assert not table["holds"]["Dissipation (Eq. 18)"]


def test_scores_are_of_the_motion_and_the_truth_is_above_what_is_wrong(recordings):
    runs = every_seed(RUNS)
    table = score_runs(runs, [recordings["ID"], recordings["T4"]], SIGNALS, metric_settings(CONFIG))
    assert len(table) == 3 * (3 + 4) * 2 * 2  # seeds, methods, motions, joints
    total = table.groupby(["method", "case"])["total"].mean()
    for case in ("ID", "T4"):
        assert total["true", case] > total["least-squares", case]
        assert total["true", case] > 0.9
    seeded = table[table["method"] == "true"].groupby(["case", "joint"])["total"].nunique()
    assert (seeded == 1).all()


@pytest.mark.parametrize("motion", ["ID", "T3"])
def test_least_squares_sees_the_signals_that_algorithm_1_sees(recordings, motion):
    found = recordings[motion].regression(SIGNALS)
    canonical = prepare(found, np.ones_like(found.tau), SIGNALS).regression
    for name in ("q", "dq", "ddq", "tau", "y"):
        np.testing.assert_array_equal(getattr(found, name), getattr(canonical, name))


def test_least_squares_finds_the_arm_of_a_perfect_run(recordings):
    run = least_squares_of(recordings["T3"], SIGNALS, TRUE)
    assert (run["variant"], run["seed"]) == ("least-squares", 0)
    methods = run["arms"]["ID"]["methods"]
    assert methods["true"]["beta"] == TRUE.tolist()
    found, r = np.array(methods["least-squares"]["beta"]), recordings["T3"].regression(SIGNALS)
    assert np.linalg.norm(r.tau - r.y @ found) < 0.05 * np.linalg.norm(r.tau)
    np.testing.assert_allclose(found[3:5], TRUE[3:5], rtol=0.05)


def test_the_field_s_methods_keep_what_they_promise(recordings):
    """On the stored run, whose ordinary solution has a negative I2; bounds cost a tenth of the residual at most."""
    config = full_config()
    stored = read_recording(Path(config["experiment"]["captures"]) / "ID.bin", config)
    signals = signal_settings(config)
    methods = least_squares_of(stored, signals, TRUE)["arms"]["ID"]["methods"]
    found = {name: np.array(methods[name]["beta"]) for name in ("least-squares", "bounded", "consistent")}
    assert found["least-squares"].min() < 0
    assert found["bounded"].min() >= 0
    assert is_positive_definite(found["consistent"])
    assert found["consistent"][5:].min() >= 0
    f = stored.regression(signals)
    error = {name: np.linalg.norm(f.tau - f.y @ beta) for name, beta in found.items()}
    assert error["least-squares"] < min(error["bounded"], error["consistent"])
    assert max(error.values()) < 1.1 * error["least-squares"]
