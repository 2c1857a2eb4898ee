"""Algorithm 1: lines 8 to 32, and the whole of it in one call; `preprocessing` has lines 1 to 12."""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from repro.cnn.image import ImageSettings, image_factors
from repro.identification.algorithm1.preprocessing import PreparedSignals, filtered, prepare
from repro.model.dynamics import rebuild_torque
from repro.model.parameters import FEASIBILITY, Array
from repro.signals.dct import SignalSettings
from repro.signals.metric import MetricSettings, TorqueScorer
from repro.streams import Stream, stream

if TYPE_CHECKING:
    from repro.cnn.network import FactoredCNN

ImageMotion = Literal["measured", "desired"]

ARM_THRESHOLD = 0.9237  # similarity d_u that an execution must reach on an arm (Section VI)


@dataclass(frozen=True)
class SearchSettings:
    """Constants of Algorithm 1."""

    executions: int = 100  # N_exe (Section VI)
    inner_limit: int = 100  # L_exe, guesses within one execution; the paper does not give it
    threshold: float = 0.9282  # d_u: 0.9282 for numeric, 0.9237 for experimental data (Section VI)
    low: float = 1e-3  # smallest guess of line 17, in units of the largest torque
    high: float = 3.0  # largest guess
    #: What line 22 calls physically possible: "positive" (all nine parameters) or "positive-definite" (the
    #: inertia matrix in every pose; no negative friction).
    feasibility: str = "positive"
    metric: MetricSettings = field(default_factory=MetricSettings)  # formulas of similarity; not public: leave it out
    #: Motion that f of the image is taken on, line 18: "measured" as listed, or "desired", the one that was sent. The
    #: function `algorithm1` knows the measured one only.
    image_motion: ImageMotion = "measured"

    def __post_init__(self) -> None:
        for name in ("executions", "inner_limit"):
            value = getattr(self, name)
            if not isinstance(value, int) or value < 1:
                raise ValueError(f"{name}: expected an integer of at least 1, got {value!r}.")
        if not 0.0 <= self.threshold <= 1.0:
            raise ValueError(f"threshold: expected a fraction of 1, got {self.threshold!r}.")
        if not 0.0 < self.low < self.high:
            raise ValueError(f"low, high: expected 0 < low < high, got {self.low!r} and {self.high!r}.")
        for name, known in (("feasibility", tuple(FEASIBILITY)), ("image_motion", get_args(ImageMotion))):
            if getattr(self, name) not in known:
                raise ValueError(f"{name}: expected one of {', '.join(known)}, got {getattr(self, name)!r}.")


@dataclass(frozen=True)
class Candidates:
    """The set beta_m of line 29."""

    beta: Array  # physically possible estimates (n, 9), in units of the largest torque
    similarity: Array  # n_e of line 27, (n,)


@dataclass(frozen=True)
class Selected:
    """Output of Algorithm 1."""

    beta: Array  # beta_o (9,), SI units
    similarity: float  # mean total of both joints on the full-rate signals (line 30)


BATCH = 100  # images that the network evaluates at a time


class ResidualEstimator:
    """Lines 17 to 21 for many guesses of one torque at once: guess -> image -> CNN -> residual -> estimate."""

    def __init__(self, network: "FactoredCNN", image: ImageSettings, signals: PreparedSignals) -> None:
        self._network = network
        self._image = image
        self._alpha = signals.alpha.astype(np.float32)
        self._model = signals.model.reshape(-1, 9).T
        #: Images evaluated so far.
        self.images = 0

    def estimate(self, guess: Array) -> Array:
        """Compute estimates beta = r + beta_n (lines 18 to 21) from guesses, (n, 9) in units of the largest torque."""
        parts = [self._residual(guess[k : k + BATCH]) for k in range(0, len(guess), BATCH)]
        self.images += len(guess)
        return guess + np.concatenate(parts) if parts else guess

    def _residual(self, guess: Array) -> Array:
        import torch  # noqa: PLC0415  (settings and scores need no network)

        psi = 2 * self._alpha - (guess @ self._model).reshape(-1, *self._alpha.shape).astype(np.float32)
        u, v = image_factors(np.broadcast_to(self._alpha, psi.shape), psi, self._image)
        with torch.no_grad():
            # Lines 19 and 20: the sigmoid of the output layer and its inverse cancel.
            residual: torch.Tensor = self._network(torch.from_numpy(u), torch.from_numpy(v[:1].copy()))
        return residual.numpy().astype(np.float64)


def search(
    estimator: ResidualEstimator, signals: PreparedSignals, settings: SearchSettings, rng: np.random.Generator
) -> Candidates:
    """Lines 8 to 29: repeat guess, image, CNN and evaluation, and return every physically possible estimate.

    All executions advance together, each with its own random stream: the network evaluates their guesses as one batch.
    """
    possible = FEASIBILITY[settings.feasibility]
    score = TorqueScorer(signals.alpha, signals.y_sub, settings.metric)
    streams = rng.spawn(settings.executions)  # line 13: for k_T = 1 to N_exe
    running = np.arange(settings.executions)  # lines 14, 15: n_e = 0, N_it = 0
    beta_m, similarity = [np.empty((0, 9))], [np.empty(0)]  # line 11
    for _ in range(settings.inner_limit):  # lines 9, 10, 16: while n_e < u and N_it < L_exe
        if not running.size:
            break
        beta_n = np.stack([streams[k].uniform(settings.low, settings.high, 9) for k in running])  # line 17
        beta = estimator.estimate(beta_n)  # lines 18 to 21
        ok = possible(beta)  # line 22; what fails is beta = 0 with n_e = 0 (lines 23, 24)
        n_e = np.zeros(len(beta))
        n_e[ok] = score(beta[ok]).total.mean(-1)  # lines 26, 27
        beta_m.append(beta[ok])  # line 29
        similarity.append(n_e[ok])
        running = running[n_e < settings.threshold]  # line 28 is the loop's own count
    return Candidates(np.concatenate(beta_m), np.concatenate(similarity))


def select(beta_m: Array, signals: PreparedSignals, settings: SearchSettings) -> Selected:
    """Lines 30 to 32: **high2sel** on the full-rate signals, then the levels of the input torque."""
    if not len(beta_m):  # line 11
        return Selected(np.zeros(9), 0.0)
    r = signals.regression
    similarity = TorqueScorer(r.tau / signals.torque_scale, r.y, settings.metric)(beta_m).total.mean(-1)
    best = int(similarity.argmax())
    beta_o = beta_m[best]  # line 30
    tau_r = rebuild_torque(r.y, beta_o)  # line 31
    tau_c = signals.c_p * r.tau  # line 6
    beta_o = beta_o * np.abs(tau_c).max() / (signals.c_p * np.abs(tau_r).max())  # line 32
    return Selected(signals.to_recorded_time(beta_o), float(similarity[best]))


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
    >>> run = repro.read_log("data/captures/ID.bin")
    >>> network = repro.load_network("data/networks/cnn.safetensors")
    >>> few = repro.SearchSettings(executions=3, inner_limit=5, threshold=0.9237)
    >>> found = repro.algorithm1(run.q, run.tau, network, begin=340, end=4110, search_settings=few)
    >>> found.beta.shape
    (9,)
    """
    signals = signals or SignalSettings()
    constants = search_settings or SearchSettings(threshold=ARM_THRESHOLD)
    recorded = filtered(q, tau, signals, begin, end)
    # Line 5 fits the level to the mean training torque. Line 32 divides by that factor again, so any level will do.
    slower = round(signals.duration / signals.h) / recorded.t.size
    prepared = prepare(recorded, recorded.tau, signals, slower)
    estimator = ResidualEstimator(network, ImageSettings(), prepared)
    candidates = search(estimator, prepared, constants, stream(seed, Stream.EXPERIMENT_SEARCH))
    return select(candidates.beta, prepared, constants)
