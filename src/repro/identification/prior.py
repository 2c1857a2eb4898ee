"""A Gaussian prior of the parameters: rows next to those of a regression (generalised least squares).

A row beta_k = m_k has the standard deviation s_k of the prior. The errors of a log are correlated from row to row: n
rows are worth n / c independent ones, with c the integrated autocorrelation time of the residual over the sampling
period. The rows of the prior are therefore multiplied by sigma sqrt(c) / s_k, with sigma the residual of the log alone.
A parameter with s_k = 0 is known: its torque is subtracted, and its column is set to zero.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from repro.model.parameters import Array


@dataclass(frozen=True, eq=False)
class Prior:
    """Means and standard deviations of the nine parameters."""

    mean: Array  # (9,), SI; 0 where nothing is known
    sd: Array  # (9,); infinity where nothing is known, 0 where the value is known
    variance: float = 1.0  # of the torque errors of the log next to it, N^2 m^2
    correlated: float = 1.0  # rows of that log that are worth one independent row
    inflation: float | Array = 1.0  # whole over sampling variance of the log's own estimates (9,)

    @property
    def known(self) -> NDArray[np.bool_]:
        """Whether each parameter (9,) is known."""
        return np.asarray(self.sd == 0.0)

    @property
    def informative(self) -> list[int]:
        """Parameters with a standard deviation that is neither 0 nor infinite, by number."""
        return [int(k) for k in np.flatnonzero(np.isfinite(self.sd) & ~self.known)]

    @property
    def precision(self) -> Array:
        """Weight (9,) of each squared error of the prior next to squared errors of rows of variance 1."""
        weight = np.zeros(len(self.sd))
        inflation = np.broadcast_to(self.inflation, weight.shape)
        weight[self.informative] = self.correlated * inflation[self.informative] / self.sd[self.informative] ** 2
        return weight

    @property
    def values(self) -> Array:
        """The known parameters (9,), 0 for the others."""
        return np.where(self.known, self.mean, 0.0)

    def shifted(self, k: int) -> "Prior":
        """Move the mean of a parameter by its standard deviation."""
        mean = self.mean.copy()
        mean[k] += self.sd[k]
        return replace(self, mean=mean)
