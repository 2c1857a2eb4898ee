"""Designed motions: within limits, at rest at the ends, and telling what they are said to tell."""

from dataclasses import replace

import numpy as np
import pytest
from experiment_example import refused
from hypothesis import given, settings
from hypothesis import strategies as st

from repro import progress
from repro.identification.armfile import Arm
from repro.identification.exciting_motion import Envelope, design, expected_accuracy, published
from repro.model.dynamics import ArmGeometry, forward_kinematics, inverse_dynamics, regressor

BETA = np.array([0.12, 0.0026, 0.0227, 0.95, 0.078, 0.08, 0.0036, 0.454, 0.31])
NOISE = np.array([0.05, 0.03])
STEPS, H, HARMONICS, BOTH = 400, 0.025, 5, ((-1, 1), (-1, 1))
ARM = Arm(
    position_limit=((-1.5, 1.2), (-1.4, 2.0)),
    speed_limit=(5.0, 6.0),
    torque_limit=(1.7, 0.8),
    workspace=((-0.28, 0.26), (-0.4, 0.02)),
    link_lengths=(0.165, 0.150),
)
#: Keys of an arm that rests at 1.5 rad and cannot carry itself there.
WEAK = {"position_limit": ((1, 2), (-1, 1)), "torque_limit": (0.5, 1.0)}


def designed(limits, seed=1, finer=1):
    return design(limits, (finer * STEPS, H / finer), HARMONICS, NOISE, np.random.default_rng(seed))


def moved(motion):
    return motion.q, motion.dq, motion.ddq


def tells(motion):
    rows = (regressor(*moved(motion)) / NOISE[:, None, None]).reshape(-1, 9)
    return np.linalg.slogdet(rows.T @ rows)[1]


def check_kept(motion, arm, beta=None):
    places = [(motion.q, arm.position_limit)]
    if arm.workspace is not None:
        places += [(point, arm.workspace) for point in forward_kinematics(motion.q, ArmGeometry(*arm.link_lengths))]
    for place, limit in places:
        low, high = np.array(limit).T[..., None]
        assert ((low <= place) & (place <= high)).all()
    assert (np.abs(motion.dq).max(axis=1) <= arm.speed_limit).all()
    if beta is not None:
        assert (np.abs(inverse_dynamics(*moved(motion), beta)).max(axis=1) <= arm.torque_limit).all()


@pytest.fixture(scope="module")
def limits():
    return Envelope(ARM, BETA)


@pytest.fixture(scope="module")
def motion(limits):
    return designed(limits)


@settings(max_examples=4)
@given(
    seed=st.integers(0, 2**32 - 1),
    low=st.tuples(st.floats(-3.0, 0.5), st.floats(-3.0, 0.5)),
    width=st.tuples(st.floats(0.4, 3.0), st.floats(0.4, 3.0)),
    speed=st.tuples(st.floats(0.5, 9.0), st.floats(0.5, 9.0)),
    torque=st.floats(1.2, 4.0),
    beta=st.sampled_from([None, BETA]),
)
def test_a_motion_keeps_all_limits_rests_at_its_ends_and_tells_more_than_eq_10(seed, low, width, speed, torque, beta):
    position = tuple((a, a + w) for a, w in zip(low, width, strict=True))
    arm = Arm(position_limit=position, speed_limit=speed, torque_limit=(torque,) * 2)
    limits = Envelope(arm, beta)
    motion = designed(limits, seed)
    theirs = published(limits, (STEPS, H), HARMONICS / (STEPS * H), NOISE)
    for one in (motion, theirs):
        check_kept(one, arm, beta)
    assert motion.q[:, [0, -1]] == pytest.approx(np.stack([limits.rest] * 2, axis=1), abs=1e-12)
    assert np.abs(motion.dq[:, [0, -1]]).max() < 1e-12
    assert np.abs(motion.ddq[:, [0, -1]]).max() < 1e-10
    assert tells(motion) > tells(theirs)


def test_a_motion_uses_a_limit_up_and_consists_of_whole_multiples_of_one_frequency(motion, limits):
    assert np.abs(limits.utilisation(moved(motion))).max() > 0.99
    torque = Envelope(replace(ARM, friction_steepness=4.0), BETA).utilisation(moved(motion))[4:6] * [[1.7], [0.8]]
    np.testing.assert_allclose(torque, inverse_dynamics(*moved(motion), BETA, 4.0), atol=1e-12)
    free = Arm(position_limit=ARM.position_limit, speed_limit=ARM.speed_limit)
    theirs = published(Envelope(free), (STEPS, H), 0.5, NOISE)
    with pytest.raises(AssertionError):  # these limits do bind
        check_kept(theirs, ARM, BETA)
    size = np.abs(np.fft.rfft(motion.q[:, :-1])) / STEPS
    assert size[:, HARMONICS + 1 :].max() < 1e-12
    assert size[:, HARMONICS].max() > 1e-3


def test_limits_and_derivatives_hold_between_the_samples_and_another_seed_gives_another_motion(limits, motion):
    fine = designed(limits, seed=2, finer=10)
    assert not np.array_equal(fine.q[:, ::10], motion.q)
    check_kept(fine, ARM, BETA)
    for x, dx in ((fine.q, fine.dq), (fine.dq, fine.ddq)):
        assert np.gradient(x, fine.time, axis=1, edge_order=2) == pytest.approx(dx, abs=2e-4 * np.abs(dx).max())


def test_the_same_seed_gives_the_same_motion(limits, motion, monkeypatch):
    reports = []
    monkeypatch.setattr(progress, "Progress", lambda _: lambda *done: reports.append(done))
    assert np.array_equal(designed(limits).q, motion.q)
    assert reports == [(k, 3) for k in (1, 2, 3)]


def test_expected_intervals_are_those_of_repeated_least_squares(motion):
    half, condition, log_det = expected_accuracy(moved(motion), NOISE, 20.0)
    rng, weight = np.random.default_rng(5), 1.0 / np.repeat(NOISE, motion.time.size)
    a = regressor(*moved(motion)).reshape(-1, 9) * weight[:, None]
    clean = inverse_dynamics(*moved(motion), BETA).ravel() * weight
    errors = np.linalg.lstsq(a, clean[:, None] + rng.normal(size=(clean.size, 4000)), rcond=None)[0] - BETA[:, None]
    assert errors.std(axis=1) * 1.96 == pytest.approx(half, rel=0.05)
    assert (np.abs(errors) < half[:, None]).mean(axis=1) == pytest.approx(np.full(9, 0.95), abs=0.015)
    assert condition == pytest.approx(np.linalg.cond(a / np.linalg.norm(a, axis=0)), rel=1e-9)
    assert log_det == pytest.approx(tells(motion), rel=1e-12)


@pytest.mark.parametrize(
    ("keys", "guess", "field", "expected"),
    [
        ({"position_limit": None}, None, "position_limit", "rad"),
        ({"speed_limit": None}, None, "speed_limit", "rad/s"),
        ({"workspace": BOTH}, None, "link_lengths", "m,"),
        ({"workspace": ((0, 1), (0, 1)), "link_lengths": (0.2, 0.2)}, None, "workspace", "0, 0 rad"),
        (
            {"workspace": ((0, 1), (0, 1)), "link_lengths": (0.2, 0.2), "torque_limit": (99, 99)},
            BETA,
            "workspace",
            "",
        ),
        # The tip is inside, the elbow is not.
        ({"workspace": ((-1, 1), (-0.5, -0.3)), "link_lengths": (0.2, 0.2)}, None, "workspace", "0, 0 rad"),
        (WEAK, BETA, "torque_limit", "1.5, 0 rad"),
    ],
)
def test_limits_that_are_missing_or_leave_no_room_are_refused(keys, guess, field, expected):
    error = refused(Envelope, Arm(**({"position_limit": BOTH, "speed_limit": (1, 1)} | keys)), guess)
    assert error.place == f"arm file: {field}" and expected in error.expected
