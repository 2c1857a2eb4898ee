"""Cells, jobs, arms and their effects."""

from collections import Counter
from itertools import combinations
from unittest.mock import Mock

import numpy as np
import pandas as pd
import pytest
from experiment_example import ROOT, changed, full_config, refused

from repro.board.frames import RADIANS_PER_COUNT
from repro.config.check import load_config
from repro.experiments.arm import Recording, control_constants, true_parameters
from repro.experiments.simulated_arms import is_within_limits
from repro.files import write_tensors
from repro.model.dynamics import regressor
from repro.signals.metric import TorqueScorer
from repro.signals.programs import ReferenceTrajectory
from repro.streams import Stream, stream
from repro_studies.arms import Effects, choose, draw_law, excitation_program, read_choice, specimens, with_friction
from repro_studies.design import FACTORS, StudyCell, cells, jobs

CONFIG = full_config()


def test_searched_cells_are_a_fraction_balanced_over_pairs_of_factors():
    table = pd.DataFrame(cells(CONFIG))
    assert (len(table), table["searched"].sum()) == (4 * 4 * 3 * 3, 36)
    assert not table.duplicated(list(FACTORS)).any()
    for pair in combinations(FACTORS, 2):
        counts = table.groupby(list(pair))["searched"].sum()
        assert 0 < counts.max() <= counts.min() + 1  # every pair of levels occurs
    whole = load_config(ROOT / "config/config.yaml", ROOT / "config/study.yaml")
    assert all(cell.searched for cell in cells(whole)) and "flow" in whole.study.networks


@pytest.mark.parametrize("size", [1, 5, 12, 100])
def test_each_cell_is_in_one_job_and_a_job_has_one_excitation_and_prior(size):
    config = changed(CONFIG, study={"cells_per_job": size})
    split = jobs(config)
    assert Counter(cell for members in split.values() for cell in members) == Counter(cells(config))
    assert {len({(cell.excitation, cell.prior) for cell in members}) for members in split.values()} == {1}
    assert max(map(len, split.values())) <= size


@pytest.mark.parametrize(("excitation", "seconds"), [("eq10", 9.42), ("slow", 18.85), ("random", 9.42)])
def test_excitations_have_their_length(excitation, seconds):
    program = excitation_program(CONFIG, excitation)
    assert (program.n2 - program.n1) * program.h == pytest.approx(seconds, abs=0.01)
    assert program.n1 >= CONFIG.experiment.margin_samples
    assert np.abs(np.diff(program.q[:, :2])).max() < 1e-4  # begins at rest


def test_a_narrow_prior_stays_within_its_factor():
    arms = draw_law("narrow", np.random.default_rng(3), 500, CONFIG) / true_parameters(CONFIG)
    assert 1 / 1.5 < arms.min() < arms.max() < 1.5
    assert np.abs(np.log(arms).mean(axis=0)).max() < 0.05


def test_friction_alone_is_multiplied():
    beta = np.arange(1.0, 19.0).reshape(2, 9)
    np.testing.assert_array_equal(with_friction(beta, 0.5), np.hstack([beta[:, :5], 0.5 * beta[:, 5:]]))


def test_effects_on_a_joint_are_in_proportion_to_its_own_torque():
    beta = draw_law("wide", np.random.default_rng(1), 3, CONFIG)
    k1 = np.eye(9)[7]
    levels, more = (Effects.drawn(np.random.default_rng(2), beta + size * k1).levels for size in (0.0, 0.4))
    np.testing.assert_array_equal(more[..., 1], levels[..., 1])
    assert (more[1, :, 0] > levels[1, :, 0]).all() and (more[2:4, :, 0] < levels[2:4, :, 0]).all()


def test_what_is_observed_of_an_arm():
    """A delay of three samples, a deflection in proportion to the torque, and a torque constant that rises with it."""
    h, t = 0.0025, np.arange(400)
    q, tau = np.stack([np.sin(0.02 * t), np.cos(0.03 * t)]), np.stack([0.5 + 0.01 * t, 1.0 - 0.02 * t])
    arm, levels = 1, np.zeros((5, 2, 2))
    levels[2, 1], levels[3, 1] = (0.01, 0.02), (0.1, 0.2)
    effects, delayed = Effects(levels, np.zeros((2, 2))), Effects(levels.copy(), np.zeros((2, 2)))
    delayed.levels[4, 1] = 3 * h
    recording = Recording(ReferenceTrajectory("ID", q, 0, len(t), h), q, tau)
    found = effects.observed(arm, recording)
    np.testing.assert_allclose(found.q, q + [[0.01], [0.02]] * tau)
    np.testing.assert_allclose(found.tau, tau + [[0.1], [0.2]] * tau * np.abs(tau))
    np.testing.assert_allclose(delayed.observed(arm, recording).tau[:, 3:], found.tau[:, :-3])
    np.testing.assert_allclose(effects.times(np.array([1.0, 2.0])).observed(arm, recording).q, 2.0 * found.q - q)


def perfect_loop(config, beta, desired, *_, **__):
    """Counts of arms that follow their motions perfectly."""
    q, h = np.broadcast_to(desired, (len(beta), *desired.shape[-2:])), config.signals.sampling_period_s
    dq = np.gradient(q, h, axis=-1)
    tau = np.einsum("njtp,np->njt", regressor(q, dq, np.gradient(dq, h, axis=-1)), beta)
    return np.rint(q / RADIANS_PER_COUNT), tau / control_constants(config).torque_per_count[:, np.newaxis]


def test_an_arm_has_the_same_effects_whatever_motion_it_is_identified_by(tmp_path, monkeypatch):
    arms, choice = draw_law("narrow", np.random.default_rng(5), 3, CONFIG), tmp_path / "arms.safetensors"
    programs = {name: excitation_program(CONFIG, name) for name in ("eq10", "slow")}
    motions = {f"motion/{name}": program.q for name, program in programs.items()}
    proper = {f"proper/{name}": np.array([program.n1, program.n2]) for name, program in programs.items()}
    write_tensors(choice, {"arms/narrow": arms, **motions, **proper})
    monkeypatch.setattr("repro_studies.arms.run_loop", perfect_loop)
    levels = ((0.97, 2.0), (0.9, 1.0))
    by = {
        name: specimens(
            CONFIG, [StudyCell(name, level, "narrow", friction, False) for level, friction in levels], choice
        )
        for name in programs
    }
    for one, other in zip(*by.values(), strict=True):
        assert one.labels == other.labels | {"excitation": "eq10"}
        for a, b in zip(one.recordings[1:], other.recordings[1:], strict=True):
            np.testing.assert_array_equal(a.tau, b.tau)
        r = one.recordings[0].regression(CONFIG.signals)
        beta = np.linalg.lstsq(r.y.reshape(-1, 9), r.tau.reshape(-1))[0]
        reached = TorqueScorer(r.tau, r.y, CONFIG.metric)(beta).total.mean()
        assert one.labels["least_squares"] == pytest.approx(reached)
        assert reached == pytest.approx(one.labels["discrepancy"], abs=0.005)
    assert [one.labels["arm"] for one in by["slow"]] == [0, 1, 2, 0, 1, 2]
    np.testing.assert_array_equal([one.true[5:] for one in by["slow"]], [*(2.0 * arms[:, 5:]), *arms[:, 5:]])


def test_motions_that_no_arm_can_do_end_with_one_line(tmp_path, monkeypatch):
    """The random motion of 4 s asks too much torque of every drawn arm; numbers of a motion or prior are its own."""
    monkeypatch.setattr("repro_studies.arms.stream", used := Mock(side_effect=stream))
    study = {"excitations": ["optimal", "random"], "priors": ["narrow"], "arms": 2}
    config = changed(CONFIG, signals={"duration_s": 4.0}, experiment={"t1": {"range_of": "motion"}}, study=study)
    error = refused(choose, config, tmp_path / "arms.safetensors")
    assert error.place.endswith("study.arms") and error.found == "2"
    uses = [(Stream.STUDY_MOTION, 1), (Stream.STUDY_MOTION, 0), (Stream.STUDY_ARMS, 1)]
    uses += [(Stream.STUDY_VALIDATION, 1, k) for k in range(2)]
    assert [call.args[1:] for call in used.call_args_list] == uses


def test_tested_arms_and_the_list_of_their_law_can_do_the_same_motions(tmp_path):
    study = {"excitations": ["eq10"], "priors": ["mismatched"], "arms": 2, "training_arms": 20}
    choose(config := changed(CONFIG, study=study), out := tmp_path / "arms.safetensors")
    program, kept = read_choice(out, config, "eq10")
    assert (kept["arms/mismatched"].shape, kept["law/wide"].shape) == ((2, 9), (160 * 20, 9))
    drawn = draw_law("wide", np.random.default_rng(1), 200, config)
    shares = [is_within_limits(config, with_friction(arms, 2.0), program).mean() for arms in (kept["law/wide"], drawn)]
    assert shares[0] > 0.98 and shares[1] < 0.9
