"""Fit of the unknowns to the printed numbers, from random starts under each hypothesis."""

from functools import lru_cache
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from repro.matching.evidence import Motion, Outcome, published, record_motion
from repro.matching.unknowns import HYPOTHESES, Hypothesis
from repro.model.parameters import Array
from repro.pipeline.accepted import experiment_of
from repro.pipeline.job import Config
from repro.signals.programs import PROGRAMS
from repro.streams import Stream, stream

#: Term of an experiment that cannot be simulated, in place of each of its terms: 10 Freq., 10 Time, 10 torques, 2
#: trackings, 20 peaks.
IMPOSSIBLE, TERMS = 30.0, 52
#: Random experiments of a start, of which the one with the smallest misfit is fitted.
DRAWS = 60
#: Differences in the unit cube that slopes are taken over, one fit after another: quantised counts make slopes rough.
STEPS = (0.03, 0.01, 0.03)
#: Most experiments of a fit (without those of its slopes), and the relative change of the misfit at which it ends.
MAX_EVALUATIONS, MIN_CHANGE = 40, 3e-3


class Problem:
    """Misfit of one start; the recording of a motion is kept for as long as only other motions change."""

    def __init__(self, config: Config, hypothesis: Hypothesis, rng: np.random.Generator) -> None:
        self._config, self._hypothesis = config, hypothesis
        phase1, phase2 = (float(f"{x:.6g}") for x in rng.uniform(0.0, 2.0 * np.pi, 2))
        self._drawn = {"ripple_phase1": phase1, "ripple_phase2": phase2, "seed": int(rng.integers(1, 2**31))}
        self._anything = self.values(np.full(len(hypothesis.unknowns), 0.5))
        self._record = lru_cache(maxsize=64)(self._recorded)

    def _recorded(
        self, motion: str, values: tuple[tuple[str, Any], ...], others: tuple[tuple[str, Any], ...]
    ) -> Motion:
        return record_motion(experiment_of(dict(values + others), self._config), motion, self._config)

    def values(self, place: Array) -> dict[str, Any]:
        """Columns of the experiment at a place of the unit cube."""
        return self._hypothesis.values(place, self._drawn, published())

    def outcome(self, place: Array) -> Outcome:
        """Simulate what changed since the last places; ValueError if there is no such experiment."""
        values, motions = self.values(place), {}
        # A motion is recorded again only if what it depends on changes: the rest is the same for all.
        for name in PROGRAMS:
            of_other = {m.lower() for m in PROGRAMS if m != name}
            unused = {key for key in values if key[:2] in of_other or (key == "duration_s" and name != "ID")}
            used = tuple((key, x) for key, x in values.items() if key not in unused)
            motions[name] = self._record(name, used, tuple((key, self._anything[key]) for key in sorted(unused)))
        return Outcome(motions, self._hypothesis.tracking)

    def terms(self, place: Array) -> Array:
        """Terms of the misfit."""
        try:
            terms = np.concatenate([term.ravel() for term in self.outcome(place).terms.values()])
        except (ValueError, FloatingPointError):
            return np.full(TERMS, IMPOSSIBLE)
        return np.nan_to_num(np.clip(terms, -IMPOSSIBLE, IMPOSSIBLE), nan=IMPOSSIBLE)


def fit(config: Config, hypothesis: Hypothesis, seed: int, start: int) -> dict[str, Any]:
    """Fit from the best of random draws by a trust-region method within the ranges; gives the experiment's columns."""
    rng = stream(seed, Stream.MATCHING, HYPOTHESES.index(hypothesis), start)
    problem = Problem(config, hypothesis, rng)
    draws = rng.uniform(0.05, 0.95, (DRAWS, len(hypothesis.unknowns)))
    place = min(draws, key=lambda draw: float(np.sum(problem.terms(draw) ** 2)))
    for step in STEPS:
        # Steps are relative, so the cube is moved away from zero.
        solved = least_squares(
            lambda x: problem.terms(x - 1.0),
            place + 1.0,
            bounds=(1.0, 2.0),
            diff_step=step,
            max_nfev=MAX_EVALUATIONS,
            ftol=MIN_CHANGE,
        )
        place = np.clip(solved.x - 1.0, 1e-6, 1.0 - 1e-6)
    outcome = problem.outcome(place)
    return {
        "tracking": hypothesis.tracking,
        "back_emf_in_b": hypothesis.back_emf_in_b,
        "start": start,
        "accepted": outcome.accepted,
        "misfit": round(outcome.misfit, 3),
        **problem.values(place),
    }
