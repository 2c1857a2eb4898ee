"""The interface of a method that solves a regression, and the names of all methods.

Nothing here loads numpy, so that the command line lists the methods at once.
"""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from repro.identification.regression import Regression
    from repro.model.parameters import Array

#: Keys of `repro.identification.least_squares.METHODS`, in the order of results.
LEAST_SQUARES = (
    "ordinary",
    "weighted",
    "robust",
    "instrumental",
    "bounded",
    "consistent",
    "weighted-consistent",
    "parsimonious",
)
#: Methods that train a network for the motion, of `repro.identification.algorithm1.own_network`.
NETWORKS = ("algorithm1", "algorithm1+refinement")
GROUPS = {"all": (*LEAST_SQUARES, *NETWORKS), "least-squares": LEAST_SQUARES}  # names that stand for several methods
#: Baselines of Algorithm 1 in the tables, with the name of the method of least squares.
BASELINES = {"least-squares": "ordinary", "bounded": "bounded", "consistent": "consistent"}
#: Methods of the paper's tables, in the order of rows in their files; the first is the paper's as listed.
TABLE_METHODS = (
    "algorithm1",
    "algorithm1/one-run",
    "algorithm1+desired",
    "algorithm1+tracked-measured",
    "algorithm1+tracked",
    "algorithm1+tracked/one-run",
    "algorithm1+refinement",
    "algorithm1+local-search",
    "differential-evolution",
    "algorithm1+paper-recipe",
    "algorithm1+paper-recipe-ranges",
    *BASELINES,
    "true",
    "appendix",
)


def network_cache() -> Path:
    """Folder for trained networks, of the user's choice by XDG_CACHE_HOME."""
    home = os.environ.get("XDG_CACHE_HOME")
    return (Path(home) if home else Path("~/.cache")) / "repro"


class NoSolutionError(Exception):
    """A method found no parameters for a regression, in one line."""


@dataclass(frozen=True)
class Estimate:
    """Result of a method."""

    beta: Array  # parameters (9,), SI
    notes: tuple[str, ...] = ()  # what the method reports about itself, one line each
    choice: float = 0.0  # what the method chose from the log and `Method.repeat` keeps, for a method that chooses
    details: Mapping[str, float] = field(default_factory=dict)  # numbers that are stored next to the parameters


def as_json(estimates: Mapping[str, Estimate]) -> dict[str, Any]:
    """Convert estimates by method to the form of result files."""
    return {method: {"beta": estimate.beta.tolist(), **estimate.details} for method, estimate in estimates.items()}


@dataclass(frozen=True)
class Method:
    """One way to solve a regression."""

    name: str  # on the command line
    title: str  # in text
    citation: str  # key in the BibTeX file
    estimate: Callable[[Regression], Estimate]
    claims_intervals: bool = True  # whether it is repeated for standard errors and intervals
    needs_all_samples: bool = False  # whether it needs the log as signals, including samples of standstill
    needs_even_odd: bool = False  # whether it uses `Regression.even_odd`, which is twice as large as the regressor
    sums_suffice: bool = False  # whether Y'Y, Y'tau and tau'tau of each joint are all that it needs of a regression
    refit: Callable[[Regression, float], Array] | None = None  # for a method that chooses: beta with a kept choice
    unbiased: Callable[[Regression], Estimate] | None = None  # of a method that is biased on purpose

    def repeat(self, regression: Regression, first: Estimate) -> Array:
        """Apply the method to a replicate, with the choice of the first estimate; returns (9,)."""
        return self.estimate(regression).beta if self.refit is None else self.refit(regression, first.choice)
