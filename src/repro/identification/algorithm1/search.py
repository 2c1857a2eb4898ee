"""Algorithm 1: lines 8 to 32, and the whole of it in one call; `preprocessing` has lines 1 to 12."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from repro.cnn.image import ImageSettings, guess_factors, torque_factors
from repro.identification.algorithm1.preprocessing import PreparedSignals, filtered, prepare
from repro.keys import SECTION, Count, Key, Positive, Share, renamed
from repro.model.dynamics import rebuild_torque
from repro.model.parameters import FEASIBILITY, Array
from repro.signals.dct import SignalSettings
from repro.signals.metric import PUBLISHED_METRIC, MetricSettings, TorqueScorer
from repro.streams import Stream, stream

if TYPE_CHECKING:
    from repro.cnn.network import FactoredCNN

ImageMotion = Literal["measured", "desired"]

ARM_THRESHOLD = 0.9237  # similarity d_u that an execution must reach on an arm (Section VI)


@dataclass(frozen=True)
class SearchConstants:
    """Constants of Algorithm 1."""

    __pydantic_config__ = SECTION

    executions: Annotated[Count, Key("N_exe", source="published: line 9")] = 100
    inner_limit: Annotated[Count, Key("L_exe, guesses in an execution", "guesses", "line 10")] = 1000
    threshold: Annotated[
        Share, Key("d_u, the similarity that ends an execution; of the numeric tests", "", "published: lines 8, 16")
    ] = 0.9282
    guess_low: Annotated[Positive, Key("lower end of the guesses", "largest torque", "published: line 17")] = 1e-3
    guess_high: Annotated[
        Positive, Key("upper end of the guesses", "largest torque", "published: line 17", "above `guess_low`")
    ] = 3.0
    feasibility: Annotated[
        Literal["positive", "positive-definite"],
        Key("all nine above zero, or M(q) positive definite for every q2 and no negative friction", source="line 22"),
    ] = "positive"
    #: The function `algorithm1` knows the measured one only.
    image_motion: Annotated[
        ImageMotion, Key("motion of f of the image: as listed, or the one sent (ours)", source="line 18")
    ] = "measured"


@renamed(low="guess_low", high="guess_high")
@dataclass(frozen=True)
class SearchSettings(SearchConstants):
    """Constants of Algorithm 1 with the formulas of similarity."""

    metric: MetricSettings = PUBLISHED_METRIC  # not public: leave it out

    def __post_init__(self) -> None:
        for name in ("executions", "inner_limit"):
            value = getattr(self, name)
            if not isinstance(value, int) or value < 1:
                raise ValueError(f"{name}: expected an integer of at least 1, got {value!r}.")
        if not 0.0 <= self.threshold <= 1.0:
            raise ValueError(f"threshold: expected a fraction of 1, got {self.threshold!r}.")
        if not 0.0 < self.guess_low < self.guess_high:
            found = f"{self.guess_low!r} and {self.guess_high!r}"
            raise ValueError(f"guess_low, guess_high: expected 0 < guess_low < guess_high, got {found}.")
        for name, known in (("feasibility", tuple(FEASIBILITY)), ("image_motion", get_args(ImageMotion))):
            if getattr(self, name) not in known:
                raise ValueError(f"{name}: expected one of {', '.join(known)}, got {getattr(self, name)!r}.")


@dataclass(frozen=True)
class Candidates:
    """The set beta_m of line 29, or the `KEPT` most similar of it."""

    beta: Array  # physically possible estimates (n, 9), in units of the largest torque
    similarity: Array  # n_e of line 27, (n,)
    met: int  # executions that met the threshold


@dataclass(frozen=True)
class Selected:
    """Output of Algorithm 1."""

    beta: Array  # beta_o (9,), SI units
    similarity: float  # mean total of both joints on the full-rate signals (line 30)


BATCH = 100  # images that the network evaluates at a time, and executions that advance together
#: Estimates that are kept at most, so that memory does not grow with the number of guesses. The published search makes
#: no more guesses than that. Line 30 compares on all samples what line 27 compared on a few: the winner is not always
#: the most similar of line 27, but not far behind.
KEPT = 10_000


class ResidualEstimator:
    """Lines 17 to 21 for many guesses of one torque at once: guess -> image -> CNN -> residual -> estimate."""

    def __init__(self, network: "FactoredCNN", image: ImageSettings, signals: PreparedSignals) -> None:
        import torch  # noqa: PLC0415  (settings and scores need no network)

        from repro.cnn.reader import Reader  # noqa: PLC0415

        alpha = signals.alpha.astype(np.float32)
        self._image = image
        self._v = torque_factors(alpha, image)
        self._reader = Reader(network, torch.from_numpy(self._v))
        self._twice_alpha = 2 * alpha
        self._model = signals.model.reshape(-1, 9).T.astype(np.float32)
        #: Images evaluated so far.
        self.images = 0

    def estimate(self, guess: Array) -> Array:
        """Compute estimates beta = r + beta_n (lines 18 to 21) from guesses, (n, 9) in units of the largest torque."""
        beta = guess.copy()
        for k in range(0, len(guess), BATCH):
            beta[k : k + BATCH] += self._residual(guess[k : k + BATCH])
        self.images += len(guess)
        return beta

    def _residual(self, guess: Array) -> NDArray[np.float32]:
        import torch  # noqa: PLC0415

        psi = self._twice_alpha - (guess.astype(np.float32) @ self._model).reshape(-1, *self._twice_alpha.shape)
        # Lines 19 and 20: the sigmoid of the output layer and its inverse cancel.
        return self._reader(torch.from_numpy(guess_factors(psi, self._v, self._image))).numpy()


def search(
    estimator: ResidualEstimator, signals: PreparedSignals, settings: SearchSettings, rng: np.random.Generator
) -> Candidates:
    """Lines 8 to 29: repeat guess, image, CNN and evaluation, and return the physically possible estimates.

    Executions advance together, each with its own random stream: the network evaluates their guesses as one batch.
    """
    score = TorqueScorer(signals.alpha, signals.y_sub, settings.metric)
    found = [Candidates(np.empty((0, 9)), np.empty(0), 0)]  # line 11
    for done in range(0, settings.executions, BATCH):  # line 13: for k_T = 1 to N_exe
        streams = rng.spawn(min(BATCH, settings.executions - done))  # the same as if all were spawned at once
        for each in _execute(estimator, score, settings, streams):
            found.append(each)
            if sum(len(part.beta) for part in found) > 2 * KEPT:
                found = [_most_similar(found)]
    return _most_similar(found)


def _execute(
    estimator: ResidualEstimator, score: TorqueScorer, settings: SearchSettings, streams: list[np.random.Generator]
) -> Iterator[Candidates]:
    """Lines 14 to 29 for some executions: the possible estimates of each round of guesses."""
    possible = FEASIBILITY[settings.feasibility]
    running = np.arange(len(streams))  # lines 14, 15: n_e = 0, N_it = 0
    for _ in range(settings.inner_limit):  # lines 9, 10, 16: while n_e < u and N_it < L_exe
        if not running.size:
            break
        beta_n = np.stack([streams[k].uniform(settings.guess_low, settings.guess_high, 9) for k in running])  # line 17
        beta = estimator.estimate(beta_n)  # lines 18 to 21
        ok = possible(beta)  # line 22; what fails is beta = 0 with n_e = 0 (lines 23, 24)
        n_e = _similarity(score, beta, ok)
        met = n_e >= settings.threshold
        yield Candidates(beta[ok], n_e[ok], int(met.sum()))  # line 29
        running = running[~met]  # line 28 is the loop's own count


def search_in_turn(
    estimator: ResidualEstimator,
    signals: PreparedSignals,
    settings: SearchSettings,
    rng: np.random.Generator,
    budgets: Sequence[int],
) -> Iterator[Candidates]:
    """Lines 8 to 29 with executions in turn and no L_exe: what is found within each budget of guesses, which rise.

    An execution ends at the threshold alone, and the next begins. The search ends with the last execution.
    """
    score, possible = TorqueScorer(signals.alpha, signals.y_sub, settings.metric), FEASIBILITY[settings.feasibility]
    found, done, met = [Candidates(np.empty((0, 9)), np.empty(0), 0)], 0, 0
    for budget in budgets:
        while done < budget and met < settings.executions:
            guess = rng.uniform(settings.guess_low, settings.guess_high, (min(BATCH, budget - done), 9))
            beta = estimator.estimate(guess)
            ok = possible(beta)
            n_e = _similarity(score, beta, ok)
            ends = np.flatnonzero(n_e >= settings.threshold)[: settings.executions - met]
            if met + len(ends) == settings.executions:
                ok[ends[-1] + 1 :] = False  # nothing is drawn after the last execution
            found.append(Candidates(beta[ok], n_e[ok], len(ends)))
            met += len(ends)
            done += len(guess)
            if sum(len(part.beta) for part in found) > 2 * KEPT:
                found = [_most_similar(found)]
        found = [_most_similar(found)]
        yield found[0]


def _similarity(score: TorqueScorer, beta: Array, ok: NDArray[np.bool_]) -> Array:
    """Lines 26 and 27: n_e of estimates (n, 9), zero for those that are not possible."""
    n_e = np.zeros(len(beta))
    n_e[ok] = score(beta[ok]).total.mean(-1)
    return n_e


def _most_similar(parts: list[Candidates]) -> Candidates:
    """Join candidates in their order, without the least similar beyond `KEPT`."""
    beta, similarity = np.concatenate([x.beta for x in parts]), np.concatenate([x.similarity for x in parts])
    best = np.sort(np.argsort(-similarity, kind="stable")[:KEPT])
    return Candidates(beta[best], similarity[best], sum(x.met for x in parts))


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
    >>> found = repro.algorithm1(run.q, run.tau, network, begin=340, end=4654, search_settings=few)
    >>> found.beta.shape
    (9,)
    """
    signals = signals or SignalSettings()
    constants = search_settings or SearchSettings(threshold=ARM_THRESHOLD)
    recorded = filtered(q, tau, signals, begin, end)
    # Line 5 fits the level to the mean training torque. Line 32 divides by that factor again, so any level will do.
    slower = round(signals.duration_s / signals.sampling_period_s) / recorded.t.size
    prepared = prepare(recorded, recorded.tau, signals, slower)
    estimator = ResidualEstimator(network, ImageSettings(), prepared)
    candidates = search(estimator, prepared, constants, stream(seed, Stream.EXPERIMENT_SEARCH))
    return select(candidates.beta, prepared, constants)
