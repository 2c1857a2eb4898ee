"""The compiled loop gives the counts of the reference plant."""

import numpy as np
import pytest

from repro.board.controller import ControlConstants, simulate
from repro.board.plant import Plant, Unmodelled
from repro.matching.compiled import record
from repro.signals.programs import TrajectorySettings, identification_reference, reference_trajectory
from repro.signals.validation_motions import RandomMotion

CONTROL = ControlConstants((180.4817, 30.6819), (1270.7266, 102.2730), (1e3, 1e3), (2.7192, 2.7314))
ARM = np.array([0.21, 0.003, 0.021, 0.93, 0.08, 0.21, 0.13, 0.32, 0.15])
ROUGH = Unmodelled((0.9, 1.4), 0.14, (0.11, 0.04), 13.7, (0.06, 0.27))


@pytest.mark.parametrize("effects", [Unmodelled(), ROUGH], ids=["Eq. 1", "all effects"])
@pytest.mark.parametrize("motion", ["ID", "T1"])
def test_counts_are_those_of_the_quick_plant(effects, motion):
    settings = TrajectorySettings(t1=RandomMotion(4000, 20.0, range_of="numbers"))
    program = (
        identification_reference(settings)
        if motion == "ID"
        else reference_trajectory(motion, settings, np.random.default_rng(4))
    )
    desired, phase = program.q[:, :1500], np.array([0.4, 5.1])
    plant = Plant(ARM, program.h, effects, phase, quick=True)
    expected = simulate(plant, CONTROL, desired)
    found = record(ARM, effects, phase, CONTROL, desired, program.h)
    assert np.ptp(found[0], axis=1).min() > 20
    # Both round in another order: a count may fall on the other side of a half.
    for ours, theirs in zip(found, expected, strict=True):
        assert np.abs(ours - theirs[0]).max() <= 1
        assert np.mean(ours != theirs[0]) < 0.002
