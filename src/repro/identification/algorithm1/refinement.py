"""Refinement, an extension of ours and not the paper's: guesses drawn from the best estimates, read by the network.

The moves are those of differential evolution [1]_: each of the best candidates is moved along the difference of two
others. Such differences are large and correlated in what the similarity leaves open, small in what it has settled,
and shrink as the set closes in, so the moves need no scale of their own even where the parameters are badly
conditioned. Each difference has a random length, no parameters are crossed over, and the best of old and new
together survive; [1]_ does otherwise on all three.

The network reads the moved guesses of the first passes, and both they and its readings become candidates. Two controls
measure the network's share. One makes the same moves from the same candidates and reads no further image. The other
starts from uniform guesses and reads no image at all.

.. [1] R. Storn and K. Price, "Differential Evolution - A Simple and Efficient Heuristic for Global Optimization over
   Continuous Spaces", Journal of Global Optimization 11, 341-359, 1997. doi:10.1023/A:1008202821328
"""

from copy import deepcopy
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from repro.identification.algorithm1.listing import Prepared
from repro.identification.algorithm1.search import SearchSettings
from repro.model.parameters import FEASIBILITY, Array
from repro.signals.metric import TorqueScorer

if TYPE_CHECKING:
    from repro.identification.algorithm1.residual import ResidualReader


@dataclass(frozen=True)
class RefinementSettings:
    """Budget and moves of the refinement.

    Attributes
    ----------
    restarts : int
        Fresh guesses beside the candidates of Algorithm 1.
    keep : int
        Most similar candidates that survive a pass and are moved in the next.
    passes : int
        Number of passes; with none there is no refinement.
    read_passes : int
        Passes whose guesses the network reads. In those after, moves and selection go on without it: by then the set
        closes in on what the similarity prefers, and a reading costs a hundred times a comparison.
    reach : float
        Largest multiple of a difference that a candidate is moved by.
    jitter : float
        Standard deviation of the normal numbers added to a moved candidate, in units of the largest torque: they
        reach where the differences do not, such as when a single candidate is left.
    starts : int
        Refinements of the same candidates along other moves, all of whose results are candidates. On a short log of
        a real arm three of ten end in a local optimum.
    """

    restarts: int = 500
    keep: int = 200
    passes: int = 200
    read_passes: int = 4
    reach: float = 1.2
    jitter: float = 1e-4
    starts: int = 1


def restart(
    reader: "ResidualReader",
    beta_m: Array,
    search: SearchSettings,
    settings: RefinementSettings,
    rng: np.random.Generator,
) -> Array:
    """Candidates that the refinement and its control start from.

    Parameters
    ----------
    reader : ResidualReader
        Network and torque.
    beta_m : array of shape (n, 9)
        Candidates of Algorithm 1, in units of the largest torque.
    search : SearchSettings
        Range of guesses and the check of line 22.
    settings : RefinementSettings
        Number of fresh guesses.
    rng : numpy.random.Generator
        Source of the fresh guesses.

    Returns
    -------
    array of shape (m, 9)
        `beta_m` and what the network makes of fresh guesses, as far as physically possible. Where none is, the
        fresh ones raised to the lowest guess: a network can read every guess a little below zero, and from nothing
        no move starts.
    """
    possible = FEASIBILITY[search.feasibility]
    fresh = reader.estimate(rng.uniform(search.low, search.high, (settings.restarts, 9)))
    candidates = np.concatenate([beta_m, fresh[possible(fresh)]])
    if len(candidates):
        return candidates
    raised = np.maximum(fresh, search.low)
    return raised[possible(raised)]


def uniform_guesses(search: SearchSettings, rng: np.random.Generator) -> Array:
    """Draw the candidates of the control without a network.

    Parameters
    ----------
    search : SearchSettings
        Range of guesses, their number and the check of line 22.
    rng : numpy.random.Generator
        Source of the guesses.

    Returns
    -------
    array of shape (n, 9)
        The physically possible ones of as many guesses as Algorithm 1 reads at most, in units of the largest torque.
    """
    guesses = rng.uniform(search.low, search.high, (search.executions * search.inner_limit, 9))
    possible: Array = guesses[FEASIBILITY[search.feasibility](guesses)]
    return possible


def refine(
    reader: "ResidualReader | None",
    candidates: Array,
    prepared: Prepared,
    search: SearchSettings,
    settings: RefinementSettings,
    rng: np.random.Generator,
) -> Array:
    """Move the best candidates, pass by pass.

    Parameters
    ----------
    reader : ResidualReader or None
        Network and torque. None: a control, whose moved guesses are candidates that no network reads.
    candidates : array of shape (m, 9)
        From `restart` or `uniform_guesses`, in units of the largest torque.
    prepared : Prepared
        Signals that candidates are compared on.
    search : SearchSettings
        Range of guesses, the check of line 22 and the metric.
    settings : RefinementSettings
        Budget and moves.
    rng : numpy.random.Generator
        Source of the moves, left as it was: refinement and control make the same ones.

    Returns
    -------
    array of shape (k, 9)
        The ``settings.keep`` most similar of `candidates` and of every physically possible one of every pass, best
        first; fewer if there are not as many, none if there was no candidate to start from.
    """
    if not len(candidates):
        return candidates
    rng = deepcopy(rng)
    possible = FEASIBILITY[search.feasibility]
    score = TorqueScorer(prepared.regression.tau / prepared.largest, prepared.regression.y, search.metric)
    best, similarity = _most_similar(candidates, score(candidates).total.mean(-1), settings.keep)
    for done in range(settings.passes):
        guess = _move(best, settings, search.low, rng)
        beta = guess
        if reader is not None and done < settings.read_passes:
            beta = np.concatenate([guess, reader.estimate(guess)])
        beta = beta[possible(beta)]
        candidates = np.concatenate([best, beta])
        similarity = np.concatenate([similarity, score(beta).total.mean(-1)])
        best, similarity = _most_similar(candidates, similarity, settings.keep)
    return best


def _most_similar(beta: Array, similarity: Array, keep: int) -> tuple[Array, Array]:
    """The candidates that survive, best first: a pass moves these and line 30 takes one, so no other is needed."""
    order = np.argsort(-similarity, kind="stable")[:keep]
    return beta[order], similarity[order]


def _move(best: Array, settings: RefinementSettings, low: float, rng: np.random.Generator) -> Array:
    """A guess from each candidate: best_i + U(0, reach) (best_a - best_b) + jitter N(0, 1), shape (n, 9)."""
    a, b = rng.integers(len(best), size=(2, len(best)))
    reach = rng.uniform(0.0, settings.reach, (len(best), 1))
    move = reach * (best[a] - best[b]) + settings.jitter * rng.standard_normal(best.shape)
    guess: Array = np.maximum(best + move, low)  # a guess below the published range was never seen in training
    return guess
