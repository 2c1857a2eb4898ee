"""Refinement, an extension of ours and not the paper's: the best estimates go back in as the next guesses.

An error that the network makes near a match depends on the guess it was shown, so each pass shows it guesses spread a
little around the best estimates so far, and the similarity picks among what comes back. How much of the gain is the
network's and how much the selection's is told by the control without feeding back.
"""

from dataclasses import dataclass

import numpy as np

from repro.identify.algorithm1 import SearchSettings
from repro.identify.prepare import Prepared
from repro.identify.residual import ResidualReader
from repro.model.feasibility import CHECKS
from repro.model.parameters import Array
from repro.signals.metric import TorqueScorer


@dataclass(frozen=True)
class RefinementSettings:
    """Budget of the refinement.

    Attributes
    ----------
    restarts : int
        Fresh guesses beside the candidates of Algorithm 1.
    keep : int
        Most similar estimates that are fed back in each pass.
    passes : int
        Number of passes. Every estimate of every pass stays a candidate.
    spread_low, spread_high : float
        Range of the log-uniform standard deviation by which a fed-back guess is spread, in units of the
        largest torque.
    """

    restarts: int = 2000
    keep: int = 200
    passes: int = 40
    spread_low: float = 3e-3
    spread_high: float = 5e-2

    def __post_init__(self) -> None:
        """Refuse budgets that cannot be."""
        if self.restarts < 0 or self.keep < 1 or self.passes < 1:
            raise ValueError("restarts, keep, passes: must be at least 0, 1 and 1.")
        if not 0 < self.spread_low < self.spread_high:
            raise ValueError("spread_low, spread_high: must be positive with low below high.")


def refine(
    reader: ResidualReader,
    beta_m: Array,
    prepared: Prepared,
    search: SearchSettings,
    settings: RefinementSettings,
    rng: np.random.Generator,
    feed_back: bool = True,
) -> Array:
    """Feed the best estimates back as guesses.

    Parameters
    ----------
    reader : ResidualReader
        Network and torque.
    beta_m : array of shape (n, 9)
        Candidates of Algorithm 1.
    prepared : Prepared
        Signals that estimates are compared on.
    search : SearchSettings
        Range of guesses, the check of line 22 and the metric.
    settings : RefinementSettings
        Budget.
    rng : numpy.random.Generator
        Source of the fresh guesses and of the spread.
    feed_back : bool
        False: the spread guesses are candidates as they are, unread by the network. The control that tells
        what selection alone achieves.

    Returns
    -------
    array of shape (m, 9)
        `beta_m` and every physically possible estimate of every pass.
    """
    possible = CHECKS[search.feasibility]
    score = TorqueScorer(prepared.tau / prepared.largest, prepared.y, search.metric)
    fresh = reader.estimate(rng.uniform(search.low, search.high, (settings.restarts, 9)))
    candidates = np.concatenate([beta_m, fresh[possible(fresh)]])
    similarity = score(candidates).total.mean(-1)
    for _ in range(settings.passes):
        best = candidates[np.argsort(-similarity, kind="stable")[: settings.keep]]
        low, high = np.log([settings.spread_low, settings.spread_high])
        spread = np.exp(rng.uniform(low, high, (len(best), 1)))
        # A guess below the published range was never seen in training.
        guess = np.maximum(best + spread * rng.standard_normal(best.shape), search.low)
        beta = reader.estimate(guess) if feed_back else guess
        beta = beta[possible(beta)]
        candidates = np.concatenate([candidates, beta])
        similarity = np.concatenate([similarity, score(beta).total.mean(-1)])
    return candidates
