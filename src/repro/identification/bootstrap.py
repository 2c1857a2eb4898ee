"""Standard errors that allow for correlated residuals and for the choice of the filter.

Filtering and friction that Eq. 1 does not hold leave residuals correlated over seconds, so single samples must not be
redrawn: the moving block bootstrap [1]_ redraws stretches of the log, regressor and torque together. To its variance is
added what the estimate moves when cut-off and width of the filters are chosen a little differently: on a clean log
that, not noise, is what limits it. A method that is biased on purpose adds its bias.

.. [1] H. R. Kuensch, "The Jackknife and the Bootstrap for General Stationary Observations", Annals of Statistics 17,
   1217-1241, 1989. doi:10.1214/aos/1176347265
"""

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from scipy.stats import t as student

from repro.identification.alternatives import BEYOND, SMEARED, Alternative
from repro.identification.methods.interface import Estimate, Method, NoSolutionError
from repro.identification.regression import Regression
from repro.identification.residuals import correlation_time
from repro.model.parameters import Array

REPLICATES = 200
#: Blocks span so many correlation times, and a log holds at least so many blocks.
CORRELATION_TIMES = 5.0
FEWEST_BLOCKS = 20
#: Parts of a log that are left out in turn.
PARTS = 6
#: Ratio of the variances by parts and by blocks that chance reaches in one log of twenty.
BY_CHANCE = 2.2


@dataclass(frozen=True)
class Spread:
    """How far an estimate may be off.

    Attributes
    ----------
    standard_error : array of shape (9,)
        Of block bootstrap and filter choice together.
    low, high : arrays of shape (9,)
        Ends of the 95 % interval.
    """

    standard_error: Array
    low: Array
    high: Array


def block_length(error: Array, h: float) -> int:
    """Samples in a block, from the residuals of a fit, shape (2, n)."""
    n = error.shape[-1]
    wanted = round(CORRELATION_TIMES * correlation_time(error, h) / h)
    return int(np.clip(wanted, 1, max(n // FEWEST_BLOCKS, 1)))


def redraw(n: int, length: int, rng: np.random.Generator) -> np.ndarray[tuple[int], np.dtype[np.intp]]:
    """Numbers of the samples of one replicate: stretches of `length` that begin anywhere, `n` in all."""
    starts = rng.integers(0, n - length + 1, size=-(-n // length))
    rows: np.ndarray[tuple[int], np.dtype[np.intp]] = (starts[:, None] + np.arange(length)).reshape(-1)[:n]
    return rows


def jackknife(method: Method, regression: Regression, first: Estimate) -> Array:
    """Variance of a method by leaving out a part of the log at a time, shape (9,).

    What changes slowly, or in one part alone, moves this and no bootstrap of short blocks.
    """
    n = regression.t.size
    place = np.arange(n) * PARTS // n
    found = []
    for part in range(PARTS):
        with suppress(NoSolutionError):
            found.append(method.repeat(regression.take(np.flatnonzero(place != part)), first))
    if len(found) < 2:
        return np.zeros(len(first.beta))
    variance: Array = (len(found) - 1) * np.var(found, axis=0)
    return variance


def bootstrap(
    method: Method,
    regression: Regression,
    first: Estimate,
    as_good: Mapping[str, Alternative],
    rng: np.random.Generator,
    replicates: int = REPLICATES,
    report: Callable[[int, int], None] = lambda *_: None,
) -> Spread:
    """Standard errors and 95 % intervals of a method.

    Parameters
    ----------
    method : Method
        Repeated on each replicate.
    regression : Regression
        Its regression.
    first : Estimate
        What it found.
    as_good : mapping of Alternative
        The same log with something chosen otherwise, by what, see `repro.identification.alternatives`.
    rng : numpy.random.Generator
        Draws the blocks.
    replicates : int
        Number of them.
    report : callable
        Called with replicates done and in all.

    Returns
    -------
    Spread
        Student's t with one degree of freedom less than there are blocks.

    Raises
    ------
    NoSolutionError
        If the method has no solution on most replicates, or on the log through another filter.
    """
    n, beta = regression.t.size, first.beta
    length = block_length(regression.tau - regression.y @ beta, regression.h)
    drawn = []
    for k in range(replicates):
        replicate = regression.take(redraw(n, length, rng))
        with suppress(NoSolutionError):  # a stretch drawn so often that it determines too little
            drawn.append(method.repeat(replicate, first))
        report(k + 1, replicates)
    if len(drawn) < max(replicates // 2, 2):
        raise NoSolutionError("most replicates of the bootstrap have no solution")
    variance = np.var(drawn, axis=0, ddof=1)
    slow = jackknife(method, regression, first)
    variance = np.where(slow > BY_CHANCE * variance, slow, variance)
    beyond, shrunk = np.zeros((2, len(beta)))
    for name, other in as_good.items():
        moved = [method.repeat(regression, first) - beta for regression in other.regressions]
        square = other.weight * np.mean(np.square(moved), axis=0)
        if name == SMEARED:  # a bias, no standard deviation
            shrunk = square
        elif name in BEYOND:  # different explanations of the same residual: the one that matters most counts
            beyond = np.maximum(beyond, square)
        else:
            variance += square
    variance += beyond
    if method.unbiased is not None:
        variance += (method.unbiased.estimate(regression).beta - beta) ** 2
    error = np.sqrt(variance)
    reach = np.sqrt((float(student.ppf(0.975, max(n // length - 1, 1))) * error) ** 2 + shrunk)
    return Spread(error, beta - reach, beta + reach)
