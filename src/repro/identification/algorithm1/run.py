"""Algorithm 1, its refinement and the refinement's two controls on one arm's signals."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from repro.cnn.image import ImageSettings
from repro.cnn.network import FactoredCNN
from repro.identification.algorithm1.listing import Prepared
from repro.identification.algorithm1.refinement import RefinementSettings, refine, restart, uniform_guesses
from repro.identification.algorithm1.residual import ResidualReader
from repro.identification.algorithm1.search import SearchSettings, Selected, search, select
from repro.identification.method import Estimate
from repro.model.parameters import Array

#: Control of the refinement without a network.
WITHOUT_NETWORK = "differential-evolution"


@dataclass(frozen=True)
class Algorithm1:
    """A trained network with the settings it is used with.

    Attributes
    ----------
    variant : str
        Network's name, which methods carry behind theirs unless it is the published one.
    network : FactoredCNN
        Trained network.
    image : ImageSettings
        Divisors of Eq. 9 that it was trained with.
    search : SearchSettings
        Constants of Algorithm 1.
    refinement : RefinementSettings
        Budget of the refinement; with no passes there is none.
    """

    variant: str
    network: FactoredCNN
    image: ImageSettings
    search: SearchSettings
    refinement: RefinementSettings

    @property
    def literal(self) -> "Algorithm1":
        """The same without refinement."""
        return replace(self, refinement=replace(self.refinement, passes=0))

    def run(
        self,
        prepared: Prepared,
        search_rng: np.random.Generator,
        refine_rng: np.random.Generator,
        uniform_rng: np.random.Generator | None = None,
    ) -> tuple[dict[str, Estimate], int]:
        """Run the search, and where it has passes the refinement and its controls.

        Parameters
        ----------
        prepared : Prepared
            Signals after line 12.
        search_rng, refine_rng : numpy.random.Generator
            Sources of the guesses of line 17 and of the refinement's.
        uniform_rng : numpy.random.Generator, optional
            Source of guesses and moves of the control without a network. The control runs with the published network
            alone, because it would be the same with every other one.

        Returns
        -------
        dict of Estimate
            By method; details are the similarity of line 30 and the images read so far.
        int
            Executions that met the threshold.
        """
        reader = ResidualReader(self.network, self.image, prepared)
        found = search(reader, prepared, self.search, search_rng)
        suffix = "" if self.variant == "published" else f"+{self.variant}"
        results = {f"algorithm1{suffix}": _estimate(select(found.beta, prepared, self.search), reader.images)}
        met = int((found.similarity >= self.search.threshold).sum())
        if not self.refinement.passes:
            return results, met
        candidates = restart(reader, found.beta, self.search, self.refinement, refine_rng)
        moves = self._moves(refine_rng)
        for method, feedback in (("local-search", None), ("refinement", reader)):  # the control reads no further image
            chosen = self._refined(feedback, candidates, prepared, moves)
            results[f"algorithm1+{method}{suffix}"] = _estimate(chosen, reader.images)
        if uniform_rng is not None and not suffix:
            guesses = uniform_guesses(self.search, uniform_rng)
            results[WITHOUT_NETWORK] = _estimate(self._refined(None, guesses, prepared, self._moves(uniform_rng)), 0)
        return results, met

    def _moves(self, rng: np.random.Generator) -> list[np.random.Generator]:
        """Sources of the moves of each start of a refinement."""
        return [rng, *rng.spawn(self.refinement.starts - 1)]

    def _refined(
        self,
        reader: ResidualReader | None,
        candidates: Array,
        prepared: Prepared,
        moves: Sequence[np.random.Generator],
    ) -> Selected:
        """The most similar set of all starts of a refinement."""
        best = [refine(reader, candidates, prepared, self.search, self.refinement, rng) for rng in moves]
        return select(np.concatenate(best), prepared, self.search)


def _estimate(selected: Selected, images: int) -> Estimate:
    return Estimate(selected.beta, details={"similarity": selected.similarity, "images": images})
