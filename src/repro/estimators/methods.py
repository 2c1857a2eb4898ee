"""The methods that solve a regression; a new one is a new file and a line here."""

from repro.estimators import bounded, consistent, instrumental, ordinary, parsimonious, robust, weighted
from repro.estimators.interface import Method

METHODS: dict[str, Method] = {
    module.METHOD.name: module.METHOD
    for module in (ordinary, weighted, robust, instrumental, bounded, consistent, parsimonious)
}
