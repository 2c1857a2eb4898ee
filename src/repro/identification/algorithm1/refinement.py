"""Algorithm 1 with its refinement, an extension of ours: the network evaluates guesses drawn from the best estimates.

The moves are those of differential evolution (Storn and Price 1997, in `fitting/methods.bib`): each of the best
candidates is moved along the difference of two others. Such differences are large and correlated in what the similarity
leaves open, small in what it has settled, and shrink as the set closes in. Unlike there, each difference has a random
length, no parameters are crossed over, and the best of old and new together survive.

Two controls measure the contribution of the network. One makes the same moves from the same candidates without further
images. The other starts from uniform guesses without any image.
"""

from copy import deepcopy
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated

import numpy as np

from repro.cnn.image import ImageSettings
from repro.identification.algorithm1.preprocessing import PreparedSignals
from repro.identification.algorithm1.search import ResidualEstimator, SearchSettings, Selected, search, select
from repro.identification.method import Estimate
from repro.keys import SECTION, Count, Key, Level, Positive, Whole
from repro.model.parameters import FEASIBILITY, Array
from repro.signals.metric import TorqueScorer

if TYPE_CHECKING:
    from repro.cnn.network import FactoredCNN


@dataclass(frozen=True)
class RefinementSettings:
    """Refinement of Algorithm 1's candidates by differential evolution."""

    __pydantic_config__ = SECTION

    restarts: Annotated[Whole, Key("fresh guesses in addition to Algorithm 1's candidates", "guesses")] = 500
    keep: Annotated[Count, Key("most similar candidates that survive a pass", "candidates")] = 200
    passes: Annotated[Whole, Key("number of passes; 0 only in section `networks`", "passes")] = 200
    #: An image costs a hundred times a comparison.
    read_passes: Annotated[Whole, Key("first passes, whose guesses the network reads", "passes")] = 4
    reach: Annotated[Positive, Key("largest multiple of a difference that a candidate is moved by")] = 1.2
    #: It reaches where the differences do not, such as when a single candidate remains.
    jitter: Annotated[Level, Key("standard deviation of the normal noise added to every move", "largest torque")] = 1e-4


def uniform_guesses(search: SearchSettings, rng: np.random.Generator) -> Array:
    """Draw the candidates (n, 9) of the control without a network: as many guesses as Algorithm 1 evaluates at most."""
    guesses = rng.uniform(search.guess_low, search.guess_high, (search.executions * search.inner_limit, 9))
    return guesses[FEASIBILITY[search.feasibility](guesses)]


def _move(best: Array, settings: RefinementSettings, low: float, rng: np.random.Generator) -> Array:
    """Draw a guess from each candidate: best_i + U(0, reach) (best_a - best_b) + jitter N(0, 1), shape (n, 9)."""
    a, b = rng.integers(len(best), size=(2, len(best)))
    reach = rng.uniform(0.0, settings.reach, (len(best), 1))
    move = reach * (best[a] - best[b]) + settings.jitter * rng.standard_normal(best.shape)
    return np.asarray(np.maximum(best + move, low))  # a guess below the published range was never seen in training


@dataclass(frozen=True)
class Algorithm1:
    """A trained network with its settings."""

    variant: str  # network's name, which is appended to those of the methods unless it is the published one
    network: "FactoredCNN"
    image: ImageSettings  # divisors of Eq. 9 that the network was trained with
    search: SearchSettings
    refinement: RefinementSettings  # with no passes there is none
    starts: int = 1  # independent runs of it that are pooled

    @property
    def literal(self) -> "Algorithm1":
        """The same without refinement."""
        return replace(self, refinement=replace(self.refinement, passes=0))

    def restart(self, estimator: ResidualEstimator, beta_m: Array, rng: np.random.Generator) -> Array:
        """Collect what is refined: `beta_m` (n, 9) and the possible estimates of fresh guesses."""
        low, possible = self.search.guess_low, FEASIBILITY[self.search.feasibility]
        fresh = estimator.estimate(rng.uniform(low, self.search.guess_high, (self.refinement.restarts, 9)))
        candidates = np.concatenate([beta_m, fresh[possible(fresh)]])
        if len(candidates):
            return candidates
        raised = np.maximum(fresh, low)
        return raised[possible(raised)]

    def refine(
        self, estimator: ResidualEstimator | None, candidates: Array, signals: PreparedSignals, rng: np.random.Generator
    ) -> Array:
        """Move the best candidates (m, 9) pass by pass, by a control without estimator; most similar come first."""
        if not len(candidates):
            return candidates
        settings, possible = self.refinement, FEASIBILITY[self.search.feasibility]
        score = TorqueScorer(signals.regression.tau / signals.torque_scale, signals.regression.y, self.search.metric)

        def survivors(old: Array, similarity: Array, new: Array) -> tuple[Array, Array]:
            beta, similarity = np.concatenate([old, new]), np.concatenate([similarity, score(new).total.mean(-1)])
            order = np.argsort(-similarity, kind="stable")[: settings.keep]
            return beta[order], similarity[order]

        best, similarity = survivors(candidates[:0], np.empty(0), candidates)
        for done in range(settings.passes):
            beta = _move(best, settings, self.search.guess_low, rng)
            if estimator is not None and done < settings.read_passes:
                beta = np.concatenate([beta, estimator.estimate(beta)])
            best, similarity = survivors(best, similarity, beta[possible(beta)])
        return best

    def run(
        self,
        signals: PreparedSignals,
        search_rng: np.random.Generator,
        refine_rng: np.random.Generator,
        uniform_rng: np.random.Generator | None = None,
    ) -> tuple[dict[str, Estimate], int]:
        """Run the search, and with passes the refinement and its controls; `uniform_rng` is for that without a network.

        Returns the estimates by method, with the similarity of line 30 and the images evaluated so far, and the number
        of executions that met the threshold.
        """
        estimator = ResidualEstimator(self.network, self.image, signals)
        candidates = search(estimator, signals, self.search, search_rng)
        suffix = "" if self.variant == "published" else f"+{self.variant}"
        results = {f"algorithm1{suffix}": _estimate(select(candidates.beta, signals, self.search), estimator.images)}
        if not self.refinement.passes:
            return results, candidates.met

        def refined(feedback: ResidualEstimator | None, starts: Array, rng: np.random.Generator) -> Selected:
            """Select the most similar set of all runs; `rng` is left unchanged: refinement and control move alike."""
            first = deepcopy(rng)
            moves = [first, *first.spawn(self.starts - 1)]
            best = [self.refine(feedback, starts, signals, each) for each in moves]
            return select(np.concatenate(best), signals, self.search)

        starts = self.restart(estimator, candidates.beta, refine_rng)
        # The control runs first, so that the number of images is its own.
        for method, feedback in (("local-search", None), ("refinement", estimator)):
            chosen = refined(feedback, starts, refine_rng)
            results[f"algorithm1+{method}{suffix}"] = _estimate(chosen, estimator.images)
        if uniform_rng is not None and not suffix:  # it would be the same with every other network
            control = refined(None, uniform_guesses(self.search, uniform_rng), uniform_rng)
            results["differential-evolution"] = _estimate(control, images=0)
        return results, candidates.met


def _estimate(selected: Selected, images: int) -> Estimate:
    return Estimate(selected.beta, details={"similarity": selected.similarity, "images": images})
