"""Do the 95 % intervals hold the truth? Twenty random arms on the simulated board, where the truth is known."""

from pathlib import Path

import numpy as np
import pytest
from board_arms import multisine, random_arms, recorded

from repro.identification.bootstrap import bootstrap
from repro.identification.methods.every import METHODS
from repro.logs.armfile import Arm
from repro.logs.description import Description
from repro.ownarm.prepared import Told, make_problem
from repro.ownarm.settings import Options
from repro.pipeline.experiment import load_config, program_from_config
from repro.streams import Stream, stream

pytestmark = pytest.mark.slow

ROOT = Path(__file__).resolve().parents[2]
ARMS = 20


@pytest.fixture(scope="module")
def problems():
    """Twenty arms with their true parameters: half on a multisine, half on the slow trajectory of Eq. 10."""
    rng = np.random.default_rng(20)
    arms = random_arms(ARMS, rng)
    slow = program_from_config(load_config(ROOT / "config" / "config.yaml"), "ID", duration=19.53).q
    logs = recorded(arms[:10], multisine(rng)) + recorded(arms[10:], slow)
    options = Options(("ordinary",), Path("unused"))
    made = []
    for log in logs:
        problem = make_problem(Told(log, Description(log.name, ())), (), Arm(), options)
        made.append((problem.regression, problem.as_good))
    return arms, made


@pytest.mark.parametrize("name", [name for name, method in METHODS.items() if method.claims_intervals])
def test_intervals_hold_the_truth_in_90_to_99_percent_of_cases(problems, name):
    arms, made = problems
    method = METHODS[name]
    inside = []
    for beta, (regression, as_good) in zip(arms, made, strict=True):
        rng = stream(1, Stream.OWN_BOOTSTRAP)
        first = method.estimate(regression)
        spread = bootstrap(method, regression, first, as_good, rng, replicates=100)
        claimed = first.beta != 0.0
        inside.append(((spread.low <= beta) & (beta <= spread.high))[claimed])
    share = np.mean(np.concatenate(inside))
    assert 0.90 <= share <= 0.99, f"{name}: {100 * share:.1f} % of {np.concatenate(inside).size} intervals"
