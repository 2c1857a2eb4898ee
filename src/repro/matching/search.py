"""Fit of the unknowns to the printed numbers, from random starts under each hypothesis."""

from collections.abc import Hashable, Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy.optimize import least_squares

from repro.config.model import Configuration
from repro.documents import read_json
from repro.experiments.accepted import SETTINGS, experiment_config
from repro.matching.evidence import Motion, Outcome, outcome_of, printed, published, record_motion
from repro.matching.unknowns import HYPOTHESES, Hypothesis
from repro.model.parameters import NAMES, Array
from repro.signals.programs import PROGRAMS
from repro.streams import Stream, stream

#: Term of an experiment that cannot be simulated, in place of each of its terms: 10 Freq., 10 Time, 10 torques, 2
#: trackings, 20 peaks.
IMPOSSIBLE, TERMS = 30.0, 52
#: Random experiments of a start, of which the one with the smallest misfit is fitted.
DRAWS = 60
#: Differences in the unit cube that slopes are taken over, one fit after another: quantised counts make slopes rough.
STEPS = (0.03, 0.01, 0.03)
#: Most times that they are gone through; an accepted experiment is not fitted further.
ROUNDS = 2
#: Most experiments of a fit (without those of its slopes), and the relative change of the misfit at which it ends.
MAX_EVALUATIONS, MIN_CHANGE = 40, 3e-3


class Problem:
    """Misfit of one start; the recording of a motion is kept for as long as only other motions change."""

    def __init__(self, config: Configuration, hypothesis: Hypothesis, rng: np.random.Generator) -> None:
        self._config, self._hypothesis = config, hypothesis
        phase1, phase2 = (float(f"{x:.6g}") for x in rng.uniform(0.0, 2.0 * np.pi, 2))
        self._drawn = {"ripple_phase1": phase1, "ripple_phase2": phase2, "seed": int(rng.integers(1, 2**31))}
        self._anything = self.values(np.full(len(hypothesis.unknowns), 0.5))
        self._record = lru_cache(maxsize=64)(self._recorded)

    def _recorded(
        self, motion: str, values: tuple[tuple[str, Any], ...], others: tuple[tuple[str, Any], ...]
    ) -> Motion:
        return record_motion(experiment_config(dict(values + others), self._config), motion)

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
        return np.asarray(np.nan_to_num(np.clip(terms, -IMPOSSIBLE, IMPOSSIBLE), nan=IMPOSSIBLE))

    def shifted_terms(self, place: Array) -> Array:
        """Terms at a place of the cube from 1 to 2: the solver's steps are relative to the place."""
        return self.terms(place - 1.0)


def fit(config: Configuration, hypothesis: Hypothesis, seed: int, start: int) -> dict[str, Any]:
    """Fit from the best of random draws by a trust-region method within the ranges; gives the experiment's columns."""
    rng = stream(seed, Stream.MATCHING, HYPOTHESES.index(hypothesis), start)
    problem = Problem(config, hypothesis, rng)
    draws = rng.uniform(0.05, 0.95, (DRAWS, len(hypothesis.unknowns)))
    place = min(draws, key=lambda draw: float(np.sum(problem.terms(draw) ** 2)))
    for fits, step in enumerate(STEPS * ROUNDS, start=1):
        solved = least_squares(
            problem.shifted_terms,
            place + 1.0,
            bounds=(1.0, 2.0),
            diff_step=[step],
            max_nfev=MAX_EVALUATIONS,
            ftol=MIN_CHANGE,
        )
        place = np.clip(solved.x - 1.0, 1e-6, 1.0 - 1e-6)
        outcome = problem.outcome(place)
        if fits >= len(STEPS) and outcome.accepted:
            break
    return {
        "tracking": hypothesis.tracking,
        "back_emf_in_b": hypothesis.back_emf_in_b,
        "start": start,
        "accepted": outcome.accepted,
        "misfit": round(outcome.misfit, 3),
        **problem.values(place),
    }


def fit_start(hypothesis: int, start: int, config: Configuration) -> dict[str, Any]:
    """Columns of one start's experiment."""
    return fit(config, HYPOTHESES[hypothesis], config.matching.seed, start)


def collect(starts: Sequence[Path], config: Configuration) -> list[pd.DataFrame]:
    """All starts, the accepted experiments with the smallest misfit first, and their misfit in each number."""
    rows = pd.DataFrame([read_json(path) for path in starts])
    accepted = rows[rows["accepted"]].sort_values("misfit", kind="stable", ignore_index=True)
    accepted.insert(0, "experiment", np.arange(1, len(accepted) + 1))
    table = accepted[["experiment", "misfit", "tracking", "back_emf_in_b", *NAMES, *SETTINGS]]
    misfits = [misfit_table(row, config) for row in table.to_dict("records")]
    return [rows, table, pd.concat(misfits, ignore_index=True)]


def misfit_table(values: Mapping[Hashable, Any], config: Configuration) -> pd.DataFrame:
    """Each number of an experiment next to the printed one, with its term of the misfit."""
    outcome, target = outcome_of(values, values["tracking"], config), printed()
    track = target.tracking if values["tracking"] == "printed" else target.tracking[::-1]
    pairs = {
        "frequency": (100.0 * outcome.scored.frequency, target.frequency),
        "time": (100.0 * outcome.scored.time, target.time),
        "torque": (outcome.mean_square, target.bound),
        "tracking": (outcome.motions["ID"].tracking[np.newaxis], track[np.newaxis]),
    }
    rows = [
        {
            **{"experiment": values["experiment"], "quantity": name, "case": PROGRAMS[k], "joint": j + 1},
            **{"ours": ours[k, j], "printed": theirs[k, j], "term": outcome.terms[name].reshape(ours.shape)[k, j]},
        }
        for name, (ours, theirs) in pairs.items()
        for k, j in np.ndindex(ours.shape)
    ]
    return pd.DataFrame(rows)
