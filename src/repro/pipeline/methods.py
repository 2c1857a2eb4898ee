"""Algorithm 1, its refinement and the refinement's control on one arm's signals."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from repro.cnn.checkpoint import load_network
from repro.cnn.factored import FactoredCNN
from repro.cnn.image import ImageSettings
from repro.identify.algorithm1 import SearchSettings, Selected, search, select
from repro.identify.prepare import Prepared
from repro.identify.refinement import RefinementSettings, refine, restart
from repro.identify.residual import ResidualReader
from repro.pipeline.named import Config
from repro.settings import data_settings, network_settings, refinement_settings, search_settings


@dataclass(frozen=True)
class Identifier:
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
        Budget of the refinement.
    """

    variant: str
    network: FactoredCNN
    image: ImageSettings
    search: SearchSettings
    refinement: RefinementSettings

    def methods(
        self,
        prepared: Prepared,
        search_rng: np.random.Generator,
        refine_rng: np.random.Generator,
    ) -> tuple[dict[str, dict[str, Any]], int]:
        """Run all three, or Algorithm 1 alone where the refinement has no passes."""
        reader = ResidualReader(self.network, self.image, prepared)
        found = search(reader, prepared, self.search, search_rng)
        suffix = "" if self.variant == "published" else f"+{self.variant}"
        results = {f"algorithm1{suffix}": _estimate(select(found.beta, prepared, self.search), reader.images)}
        met = int((found.similarity >= self.search.threshold).sum())
        if not self.refinement.passes:
            return results, met
        candidates = restart(reader, found.beta, self.search, self.refinement, refine_rng)
        for method, feed_back in (("local-search", False), ("refinement", True)):  # the control reads no further image
            best = refine(reader, candidates, prepared, self.search, self.refinement, refine_rng, feed_back)
            chosen = select(best, prepared, self.search)
            results[f"algorithm1+{method}{suffix}"] = _estimate(chosen, reader.images)
        return results, met


def _estimate(selected: Selected, images: int) -> dict[str, Any]:
    return {"beta": selected.beta.tolist(), "similarity": selected.similarity, "images": images}


def identifier_of(variant: str, weights: str, config: Config) -> Identifier:
    """A trained network with the settings of its configuration."""
    network = load_network(Path(weights), network_settings(config))
    image, search = data_settings(config).image, search_settings(config)
    return Identifier(variant, network, image, search, refinement_settings(config))


def for_the_arm(identifier: Identifier, config: Config) -> Identifier:
    """The same with the threshold of the experiment."""
    return replace(identifier, search=replace(identifier.search, threshold=config["experiment"]["threshold"]))
