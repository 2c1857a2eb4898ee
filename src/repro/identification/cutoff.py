"""Cut-off chosen from the log: the band in which the position is known and Eq. 1 explains the torque.

Two limits, the lower one counts. Above the first the position no longer stands well above its own noise, which two
differentiations blow up. Above the second, where the squared coherence of recorded and rebuilt torque is below one
half, noise and what Eq. 1 leaves out move the torque more than the motion does. The second alone is not enough: a
controller answers the noise of the position with torque, and the two then agree on nothing but noise.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.signal import csd

from repro.identification.filtering import FilterSettings, prepare
from repro.identification.solve import solve
from repro.logs.log import Log, period
from repro.model.parameters import Array

#: Squared coherence of the torque that a frequency must have to be kept.
EXPLAINED = 0.5
#: Amplitude of the position over its noise that a frequency must have to be kept: 20 dB.
ABOVE_NOISE = 10.0
LOWEST, HIGHEST = 1.0, 10.0
#: Length of a segment of the spectra, s.
SEGMENT = 3.0


@dataclass(frozen=True)
class Cutoff:
    """The choice, and what it was made by.

    Attributes
    ----------
    hertz : float
        Half-power frequency for `FilterSettings.cutoff`.
    reason : str
        One line.
    frequency : array of shape (m,)
        Hz.
    coherence : array of shape (2, m)
        Squared coherence of recorded and rebuilt torque of each joint.
    position : array of shape (2, m)
        Amplitude of the position over that of its noise, of each joint.
    highest : float
        Highest cut-off that could have been chosen, Hz.
    explained, above_noise : float
        Least `coherence` (mean of both joints) and least `position` (of the better joint) of what is kept.
    """

    hertz: float
    reason: str
    frequency: Array
    coherence: Array
    position: Array
    highest: float
    explained: float = EXPLAINED
    above_noise: float = ABOVE_NOISE


def choose_cutoff(log: Log, settings: FilterSettings) -> Cutoff:
    """Highest frequency up to which both limits are kept.

    Parameters
    ----------
    log : Log
        Uniformly sampled.
    settings : FilterSettings
        Filter; its own cut-off is not used.

    Returns
    -------
    Cutoff
        Between 1 and 10 Hz, but at most a tenth of the sampling rate.
    """
    rate = 1.0 / period(log)
    highest = min(HIGHEST, rate / 10.0)
    segment = min(round(SEGMENT * rate), log.longest.t.size // 4)
    q = [piece.q for piece in log.pieces]
    frequency, density = _density(q, q, rate, segment, "blackmanharris")
    # The noise is that of the upper half of the spectrum, where an arm does not move.
    noise = np.median(density.real[:, frequency > 0.25 * rate], axis=-1, keepdims=True)
    position = np.sqrt(density.real / np.where(noise > 0.0, noise, np.finfo(np.float64).tiny))
    band = (frequency >= LOWEST) & (frequency <= highest)
    known = _first_below(frequency[band], position.max(0)[band], ABOVE_NOISE)

    beta_at = prepare(log, replace(settings, cutoff=min(3.0, highest)))
    beta = solve(beta_at.y, beta_at.tau)
    every = replace(settings, cutoff=2.0 * highest, samples_per_cycle=np.inf)
    wide = [prepare(piece, every) for piece in log.pieces]
    tau, rebuilt = [piece.tau for piece in wide], [piece.y @ beta for piece in wide]
    segment = min(segment, max(piece.t.size for piece in wide) // 4)
    pairs = ((tau, rebuilt), (tau, tau), (rebuilt, rebuilt))
    (there, across), (_, one), (_, other) = (_density(*pair, rate, segment, "hann") for pair in pairs)
    with np.errstate(divide="ignore", invalid="ignore"):  # no torque at all
        squared = np.nan_to_num(np.abs(across) ** 2 / one.real / other.real)
    explained = np.stack([np.interp(frequency, there, joint) for joint in squared])
    fits = _first_below(frequency[band], explained.mean(0)[band], EXPLAINED)

    hertz = min(known, fits, highest)
    if hertz == highest:
        reason = f"position and torque are good up to {highest:.3g} Hz, the most that is used"
    elif fits <= known:
        reason = f"above {hertz:.3g} Hz Eq. 1 explains less than half of the torque's power"
    else:
        reason = f"above {hertz:.3g} Hz the position is less than {ABOVE_NOISE:g} times its noise"
    return Cutoff(hertz, reason, frequency, explained, position, highest)


def _density(
    x: Sequence[Array], y: Sequence[Array], rate: float, segment: int, window: str
) -> tuple[Array, NDArray[np.complex128]]:
    """Frequency and cross-spectral density of the pieces of a log that hold a segment, each by its length."""
    long = [(a, b) for a, b in zip(x, y, strict=True) if a.shape[-1] >= segment]
    found = [csd(a, b, rate, window=window, nperseg=segment, axis=-1) for a, b in long]
    weight = np.array([a.shape[-1] for a, _ in long]) / sum(a.shape[-1] for a, _ in long)
    return found[0][0], sum(part * w for (_, part), w in zip(found, weight, strict=True))


def _first_below(frequency: Array, curve: Array, limit: float) -> float:
    """Lowest frequency at which a curve is below a limit; infinity if there is none."""
    below = np.flatnonzero(curve < limit)
    return float(frequency[below[0]]) if below.size else np.inf
