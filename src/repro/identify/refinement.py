"""Refinement, an extension of ours and not the paper's: an estimate goes back in as the next guess."""

from dataclasses import dataclass

import numpy as np

from repro.identify.algorithm1 import SearchSettings
from repro.identify.residual import ResidualReader
from repro.model.feasibility import CHECKS
from repro.model.parameters import Array


@dataclass(frozen=True)
class RefinementSettings:
    """Budget of the refinement.

    Attributes
    ----------
    restarts : int
        Fresh guesses beside the candidates of Algorithm 1.
    passes : int
        How often each estimate is fed back. Every pass is kept as a candidate, because passes drift.
    """

    restarts: int = 2000
    passes: int = 4

    def __post_init__(self) -> None:
        """Refuse budgets that cannot be."""
        if self.restarts < 0 or self.passes < 1:
            raise ValueError("restarts, passes: must be at least 0 and 1.")


def refine(
    reader: ResidualReader,
    beta_m: Array,
    search: SearchSettings,
    settings: RefinementSettings,
    rng: np.random.Generator,
) -> Array:
    """Feed estimates back as guesses.

    Parameters
    ----------
    reader : ResidualReader
        Network and torque.
    beta_m : array of shape (n, 9)
        Candidates of Algorithm 1.
    search : SearchSettings
        Range of guesses and the check of line 22.
    settings : RefinementSettings
        Budget.
    rng : numpy.random.Generator
        Source of the fresh guesses.

    Returns
    -------
    array of shape (m, 9)
        `beta_m` and every physically possible estimate of every pass.
    """
    possible = CHECKS[search.feasibility]
    fresh = reader.estimate(rng.uniform(search.low, search.high, (settings.restarts, 9)))
    beta = np.concatenate([beta_m, fresh])
    kept = [beta_m, fresh[possible(fresh)]]
    for _ in range(settings.passes):
        # A guess below the published range was never seen in training.
        beta = reader.estimate(np.maximum(beta, search.low))
        kept.append(beta[possible(beta)])
    return np.concatenate(kept)
