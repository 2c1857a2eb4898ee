"""Names of the methods that solve a regression, found without loading them: the names of their files."""

import pkgutil
from pathlib import Path

#: Files of this folder that are no method.
OTHERS = {"every", "interface", "names"}
#: Methods that train a network for the motion; both are in `repro.identification.algorithm1.own_network`.
NETWORKS = ("algorithm1", "algorithm1+refinement")
#: Order in which methods are told, the simplest first; a new one comes last unless it is put in its place here.
ORDER = ("ordinary", "weighted", "robust", "instrumental", "bounded", "consistent", "parsimonious")


def names() -> tuple[str, ...]:
    """Names of all methods.

    Returns
    -------
    tuple of str
        Those of `ORDER`, then any others by the alphabet.
    """
    found = {module.name for module in pkgutil.iter_modules([str(Path(__file__).parent)])} - OTHERS
    return (*(name for name in ORDER if name in found), *sorted(found.difference(ORDER)))
