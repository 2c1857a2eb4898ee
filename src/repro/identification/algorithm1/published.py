"""Algorithm 1 as published, from recorded signals to parameters in one call."""

from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from repro.cnn.image import ImageSettings
from repro.identification.algorithm1.preprocessing import filtered, prepare
from repro.identification.algorithm1.search import ResidualEstimator, SearchSettings, Selected, search, select
from repro.model.dynamics import check_motion
from repro.signals.dct import SignalSettings
from repro.streams import Stream, stream

if TYPE_CHECKING:
    from repro.cnn.network import FactoredCNN

#: Similarity d_u that an execution must reach on an arm (Section VI).
ARM_THRESHOLD = 0.9237


def algorithm1(
    q: ArrayLike,
    tau: ArrayLike,
    network: "FactoredCNN",
    *,
    begin: int = 0,
    end: int | None = None,
    signals: SignalSettings | None = None,
    search_settings: SearchSettings | None = None,
    seed: int = 1,
) -> Selected:
    """Estimate the parameters of an arm from its run of the trajectory of Eq. 10 (Algorithm 1).

    Parameters
    ----------
    q, tau : array_like of shape (2, N)
        Measured position, rad, and torque, N m, evenly sampled.
    network : FactoredCNN
        Trained for this trajectory, see `load_network`.
    begin, end : int
        First sample of the trajectory and the one after its last.
    signals : SignalSettings, optional
        Sampling period and filter; the paper's by default.
    search_settings : SearchSettings, optional
        Constants of the search; those of Section VI by default.
    seed : int
        Of the guesses of line 17.

    Returns
    -------
    Selected
        ``beta`` (9,), SI units, and ``similarity`` of the rebuilt torque, a fraction of 1. Both are zero if no estimate
        is physically possible.

    Raises
    ------
    ValueError
        If shapes differ, values are not finite, or the trajectory is empty.

    Examples
    --------
    >>> import repro
    >>> run = repro.read_log("data/captures/ID.bin")
    >>> network = repro.load_network("data/networks/cnn.safetensors")
    >>> few = repro.SearchSettings(executions=3, inner_limit=5, threshold=0.9237)
    >>> found = repro.algorithm1(run.q, run.tau, network, begin=340, end=4110, search_settings=few)
    >>> found.beta.shape
    (9,)
    """
    signals = signals or SignalSettings()
    constants = search_settings or SearchSettings(threshold=ARM_THRESHOLD)
    q, tau = check_motion(q, tau)
    n = q.shape[-1]
    end = n if end is None else end
    if not 0 <= begin < end - signals.samples <= n - signals.samples:
        raise ValueError(f"begin, end: {begin} to {end} must lie in 0 to {n} and hold over {signals.samples} samples.")
    recorded = filtered(q, tau, signals, begin, end)
    # Line 5 fits the level to the mean training torque. Line 32 divides by that factor again, so any level will do.
    slower = round(signals.duration / signals.h) / recorded.t.size
    prepared = prepare(recorded, recorded.tau, signals, slower)
    estimator = ResidualEstimator(network, ImageSettings(), prepared)
    candidates = search(estimator, prepared, constants, stream(seed, Stream.EXPERIMENT_SEARCH))
    return select(candidates.beta, prepared, constants)
