"""Similarity of two signals in time and in frequency: ``metr2ev`` (Algorithm 2, Tables 6-8, 10).

The listing of Algorithm 2 is lost. The formulas are those that explain the printed numbers best;
`repro.paper.metric_search` ranks the alternatives. The orthonormal DCT-II keeps inner products (Parseval): with X, Y
the spectra of x, y, ``|X/|X| - Y/|Y||^2 = 2 - 2 <x, y> / (|x| |y|)``, with which `TorqueScorer` needs no transform.
"""

from dataclasses import dataclass
from typing import Annotated, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from repro.keys import SECTION, Key, Positive
from repro.model.parameters import Array, check_beta
from repro.signals.dct import spectrum

TimeFormula = Literal["mean-square", "energy"]
TIME_FORMULAS: tuple[TimeFormula, ...] = get_args(TimeFormula)


@dataclass(frozen=True)
class Similarity:
    """The two factors of Algorithm 2 (...), as fractions of 1, for each pair of signals."""

    time: Array
    frequency: Array

    @property
    def total(self) -> Array:
        """Product of both factors, the column Total of the tables."""
        return self.time * self.frequency


@dataclass(frozen=True)
class MetricSettings:
    """Formulas of metr2ev."""

    __pydantic_config__ = SECTION

    time_formula: Annotated[
        TimeFormula,
        Key("error in time: mean of (x-y)^2 in the signal's unit, or |x-y|^2 / |x|^2 (`energy`)", source="Algorithm 2"),
    ] = "mean-square"
    exponent: Annotated[Positive, Key("power on each factor", source="published: Algorithm 2")] = 0.4


PUBLISHED_METRIC = MetricSettings()
#: For logs of any arm: the energy ratio does not depend on the unit or the size of the torque.
UNIT_FREE_METRIC = MetricSettings("energy")


def _similarity(error_energy: Array, energy: Array, chord2: Array, n: int, s: MetricSettings) -> Similarity:
    """Compute both factors from |x-y|^2, |x|^2 and |X/|X| - Y/|Y||^2."""
    scale = energy if s.time_formula == "energy" else float(n)
    time = np.clip(1.0 - np.maximum(error_energy, 0.0) / scale, 0.0, 1.0) ** s.exponent
    frequency = np.clip(1.0 - np.sqrt(np.maximum(chord2, 0.0)), 0.0, 1.0) ** s.exponent
    return Similarity(time, frequency)


def metr2ev(x: ArrayLike, y: ArrayLike, settings: MetricSettings = PUBLISHED_METRIC) -> Similarity:
    """Compute the similarity of a rebuilt signal `y` to an actual signal `x` (Algorithm 2).

    time = (1 - mean((x-y)^2))^0.4 and frequency = (1 - |X/|X| - Y/|Y||)^0.4 with X, Y the DCT-II
    spectra, each floored at 0; total = time * frequency.

    Parameters
    ----------
    x : array_like of shape (..., N)
        Actual signal; must not be zero throughout.
    y : array_like of shape (..., N)
        Rebuilt signal. One that is zero throughout has similarity 0.
    settings : MetricSettings
        Formula choices of the paper's study, not public: leave it out. For torques far from 1 N m divide `x` and `y` by
        the largest of `x` before.

    Returns
    -------
    Similarity
        ``time``, ``frequency`` and their product ``total``: arrays of the broadcast leading shape, fractions of 1.

    Raises
    ------
    ValueError
        If lengths differ, a sample is not finite, or `x` is zero throughout.

    Examples
    --------
    >>> x = np.sin(np.linspace(0.0, 6.0, 50))
    >>> float(repro.similarity(x, x).total)
    1.0
    """
    x, y = np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64)
    if x.shape[-1:] != y.shape[-1:]:
        raise ValueError(f"x, y: lengths differ, {x.shape[-1:]} and {y.shape[-1:]}.")
    for name, signal in (("x", x), ("y", y)):
        if not np.isfinite(signal).all():
            raise ValueError(f"{name}: every sample must be finite.")
    bands_x, bands_y = spectrum(x), spectrum(y)
    energy_x, energy_y = np.sum(x**2, -1), np.sum(y**2, -1)
    if not (energy_x > 0).all():
        raise ValueError("x: the actual signal is zero throughout, so similarity to it is not defined.")
    # The difference of unit spectra, not 2 - 2 cos: it stays exact to rounding near similarity 1.
    unit_x = bands_x / np.sqrt(energy_x)[..., None]
    unit_y = bands_y / np.where(energy_y > 0, np.sqrt(energy_y), 1.0)[..., None]
    chord2 = np.where(energy_y > 0, np.sum((unit_x - unit_y) ** 2, -1), 2.0)
    return _similarity(np.sum((x - y) ** 2, -1), energy_x, chord2, x.shape[-1], settings)


class TorqueScorer:
    """``metr2ev`` of many parameter sets, by a 9 x 9 form each, against one torque (2, N) with regressor (2, N, 9)."""

    def __init__(self, tau: Array, y: Array, settings: MetricSettings = PUBLISHED_METRIC) -> None:
        self._settings = settings
        self._n = tau.shape[-1]
        self._energy = np.einsum("jn,jn->j", tau, tau)
        if not (self._energy > 0).all():
            raise ValueError("tau: a joint's torque is zero throughout, so similarity to it is not defined.")
        self._gram = np.einsum("jna,jnb->jab", y, y)
        self._cross = np.einsum("jna,jn->ja", y, tau)

    def __call__(self, beta: Array) -> Similarity:
        """Compute the similarity (..., 2) of each joint's torque rebuilt from parameter sets (..., 9)."""
        beta = check_beta(beta)
        cross = beta @ self._cross.T  # (..., 2)
        rebuilt = np.maximum(np.einsum("...a,jab,...b->...j", beta, self._gram, beta, optimize=True), 0.0)
        error = self._energy - 2.0 * cross + rebuilt
        norm = np.sqrt(rebuilt * self._energy)
        chord2 = 2.0 - 2.0 * np.divide(cross, norm, out=np.zeros_like(cross), where=norm > 0)
        return _similarity(error, self._energy, chord2, self._n, self._settings)
