"""Expanded uncertainty of an estimate: sampling, choices of the analysis, and effects beyond Eq. 1.

Filtering and unmodelled friction leave residuals correlated over seconds, so single samples cannot be resampled. Three
uncertainties are combined.

- Sampling: moving-block pairs bootstrap [1]_, which resamples regressor and torque together. Where the delete-a-group
  jackknife [2]_ gives a larger variance by an F-test, that variance is used: it includes errors that change slowly.
- Type B [3]_: root mean square shift of the estimate when filters, delay or calibration errors are chosen differently.
  An effect beyond Eq. 1 (`repro.identification.sensitivity`) shifts it by anything up to what its columns cause: a
  rectangular distribution, of variance a^2 / 3 for a shift of a (4.3.7). The largest counts. The bias of a method that
  is biased on purpose belongs here too.
- Bias by errors of the motion, estimated by SIMEX [4]_. It widens the interval and does not move the estimate.

Sampling and type B add up to the standard error. For the interval each is multiplied by Student's t of its own degrees
of freedom, blocks - 1 or groups - 1 for sampling and blocks - 1 for type B. The products and the bias are added in
quadrature. (The single factor of Welch and Satterthwaite can narrow an interval when an uncertainty is added.)

.. [1] H. R. Kuensch, "The Jackknife and the Bootstrap for General Stationary Observations", Annals of Statistics 17,
   1217-1241, 1989. doi:10.1214/aos/1176347265
.. [2] P. S. Kott, "The Delete-a-Group Jackknife", Journal of Official Statistics 17, 521-526, 2001.
.. [3] JCGM 100:2008, "Evaluation of Measurement Data: Guide to the Expression of Uncertainty in Measurement".
.. [4] J. R. Cook and L. A. Stefanski, "Simulation-Extrapolation Estimation in Parametric Measurement Error Models",
   Journal of the American Statistical Association 89, 1314-1328, 1994. doi:10.1080/01621459.1994.10476871
"""

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import f as fisher
from scipy.stats import t as student

from repro.identification.method import Estimate, Method, NoSolutionError
from repro.identification.regression import Regression, correlation_time
from repro.identification.sensitivity import F_TEST_LEVEL, Perturbation, type_b_variance
from repro.model.parameters import Array

REPLICATES = 200
#: Correlation times in a block, and fewest blocks in a log.
CORRELATION_TIMES_PER_BLOCK, MIN_BLOCKS = 5.0, 20
#: Groups of the jackknife: parts of the log that are left out in turn.
GROUPS = 6


@dataclass(frozen=True)
class Uncertainty:
    """Uncertainty of an estimate, each array of shape (9,)."""

    standard_error: Array  # combined standard uncertainty of sampling and type B
    low: Array  # ends of the 95 % interval
    high: Array


def block_length(error: Array, h: float) -> int:
    """Samples in a block, from the residuals (2, n) of a fit."""
    n = error.shape[-1]
    length = round(CORRELATION_TIMES_PER_BLOCK * correlation_time(error, h) / h)
    return int(np.clip(length, 1, max(n // MIN_BLOCKS, 1)))


def resample(n: int, length: int, rng: np.random.Generator) -> NDArray[np.intp]:
    """Draw the sample indices of one replicate: blocks of `length` that begin anywhere, `n` samples in all."""
    starts = rng.integers(0, n - length + 1, size=-(-n // length))
    rows: NDArray[np.intp] = (starts[:, None] + np.arange(length)).reshape(-1)[:n]
    return rows


def jackknife(method: Method, regression: Regression, first: Estimate) -> tuple[Array, int]:
    """Compute the variance (9,) by the delete-a-group jackknife and its degrees of freedom."""
    n = regression.t.size
    group = np.arange(n) * GROUPS // n
    estimates = []
    for k in range(GROUPS):
        with suppress(NoSolutionError):
            estimates.append(method.repeat(regression.take(np.flatnonzero(group != k)), first))
    freedom = len(estimates) - 1
    if freedom < 1:
        return np.zeros(len(first.beta)), 1
    return freedom * np.var(estimates, axis=0), freedom


def bootstrap(
    method: Method,
    regression: Regression,
    first: Estimate,
    perturbations: Mapping[str, Perturbation],
    rng: np.random.Generator,
    replicates: int = REPLICATES,
    report: Callable[[int, int], None] = lambda *_: None,
) -> Uncertainty:
    """Compute standard errors and 95 % intervals of a method on the regression that gave the estimate `first`.

    `report` is called with replicates done and in all. NoSolutionError is raised if the method has no solution on most
    replicates, or on the log through another filter.
    """
    n, beta = regression.t.size, first.beta
    length = block_length(regression.tau - regression.y @ beta, regression.h)
    drawn = []
    for k in range(replicates):
        replicate = regression.take(resample(n, length, rng))
        with suppress(NoSolutionError):  # a block drawn so often that it determines too little
            drawn.append(method.repeat(replicate, first))
        report(k + 1, replicates)
    if len(drawn) < max(replicates // 2, 2):
        raise NoSolutionError("most replicates of the bootstrap have no solution")
    sampling = np.var(drawn, axis=0, ddof=1)
    blocks = max(n // length - 1, 1)
    slow, groups = jackknife(method, regression, first)
    slower = slow > float(fisher.isf(F_TEST_LEVEL, groups, blocks)) * sampling
    sampling = np.where(slower, slow, sampling)
    type_b, attenuation = type_b_variance(lambda other: method.repeat(other, first), beta, perturbations)
    if method.unbiased is not None:
        type_b += (method.unbiased(regression).beta - beta) ** 2
    factors = student.ppf(0.975, np.where(slower, groups, blocks)), float(student.ppf(0.975, blocks))
    half_width = np.sqrt(factors[0] ** 2 * sampling + factors[1] ** 2 * type_b + attenuation)
    return Uncertainty(np.sqrt(sampling + type_b), beta - half_width, beta + half_width)
