"""What a method is."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from repro.identification.regression import Regression
from repro.model.parameters import Array


class NoSolutionError(Exception):
    """A method found no parameters for a regression, in one line."""


@dataclass(frozen=True)
class Estimate:
    """What a method found.

    Attributes
    ----------
    beta : array of shape (9,)
        Parameters, SI.
    notes : tuple of str
        What the method says about itself, one line each.
    choice : float
        What the method chose from the log and `Method.repeat` keeps, for a method that chooses.
    details : mapping of str to float
        Numbers that are kept beside the parameters.
    """

    beta: Array
    notes: tuple[str, ...] = ()
    choice: float = 0.0
    details: Mapping[str, float] = field(default_factory=dict)


def as_json(found: Mapping[str, Estimate]) -> dict[str, Any]:
    """Estimates by method as they are kept in files."""
    return {method: {"beta": estimate.beta.tolist(), **estimate.details} for method, estimate in found.items()}


@dataclass(frozen=True)
class Method:
    """One way to solve a regression.

    Attributes
    ----------
    name : str
        On the command line.
    title : str
        In words.
    citation : str
        Key in the BibTeX file.
    estimate : callable
        ``estimate(regression)`` gives an `Estimate`.
    claims_intervals : bool
        Whether it is repeated for standard errors and gives intervals.
    needs_all_samples : bool
        Whether it sees the log as signals, to which the samples of standstill belong.
    refit : callable or None
        ``refit(regression, choice)`` gives beta with `Estimate.choice` kept, for a method that chooses.
    unbiased : Method or None
        For a method that is biased on purpose: the one that it is biased away from. The difference of the two enters
        the standard error.
    """

    name: str
    title: str
    citation: str
    estimate: Callable[[Regression], Estimate]
    claims_intervals: bool = True
    needs_all_samples: bool = False
    refit: Callable[[Regression, float], Array] | None = None
    unbiased: "Method | None" = None

    def repeat(self, regression: Regression, first: Estimate) -> Array:
        """The method once more on a replicate, with what it chose at `first`, shape (9,)."""
        return self.estimate(regression).beta if self.refit is None else self.refit(regression, first.choice)


def joint_variance(regression: Regression, beta: Array) -> Array:
    """Mean squared torque error of each joint where it moves, shape (2, 1), N^2 m^2, never zero."""
    error = regression.tau - regression.y @ beta
    count = np.maximum(regression.moving.sum(-1, keepdims=True), 1)
    floor = np.finfo(np.float64).eps * np.sum(regression.tau**2, axis=-1, keepdims=True) / count
    floor = np.where(floor > 0.0, floor, 1.0)
    variance: Array = np.maximum(np.sum(error**2 * regression.moving, axis=-1, keepdims=True) / count, floor)
    return variance
