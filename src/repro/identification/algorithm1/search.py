"""Algorithm 1: parametric identification, lines 8 to 32; `listing` beside it holds lines 1 to 12."""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

import numpy as np

from repro.identification.algorithm1.listing import Prepared
from repro.model.dynamics import rebuild_torque
from repro.model.parameters import FEASIBILITY, Array
from repro.signals.metric import MetricSettings, TorqueScorer

if TYPE_CHECKING:
    from repro.identification.algorithm1.residual import ResidualReader


ImageMotion = Literal["measured", "desired"]


@dataclass(frozen=True)
class SearchSettings:
    """Constants of Algorithm 1.

    Attributes
    ----------
    executions : int
        N_exe = 100 (Section VI).
    inner_limit : int
        L_exe, guesses within one execution; the paper does not give it.
    threshold : float
        d_u: 0.9282 for numeric, 0.9237 for experimental data (Section VI).
    low, high : float
        Range of the guesses of line 17.
    feasibility : str
        What line 22 calls physically possible, see `repro.model.parameters`.
    metric : MetricSettings
        Formulas of **metr2ev**.
    image_motion : {"measured", "desired"}
        Motion that f of the image is taken on, line 18: the measured one as listed, or the one that was sent.
    """

    executions: int = 100
    inner_limit: int = 100
    threshold: float = 0.9282
    low: float = 1e-3
    high: float = 3.0
    feasibility: str = "positive"
    metric: MetricSettings = field(default_factory=MetricSettings)
    image_motion: ImageMotion = "measured"


@dataclass(frozen=True)
class Candidates:
    """The set beta_m of line 29.

    Attributes
    ----------
    beta : array of shape (n, 9)
        Physically possible estimates, in units of the largest torque.
    execution : array of shape (n,)
        Execution each came from.
    similarity : array of shape (n,)
        n_e of line 27.
    images : int
        Images read by the network, rejected estimates included.
    """

    beta: Array
    execution: np.ndarray[tuple[int], np.dtype[np.int64]]
    similarity: Array
    images: int


@dataclass(frozen=True)
class Selected:
    """Output of Algorithm 1.

    Attributes
    ----------
    beta : array of shape (9,)
        beta_o, SI units.
    similarity : float
        Mean total of both joints on the full-rate signals (line 30).
    """

    beta: Array
    similarity: float


def search(
    reader: "ResidualReader", prepared: Prepared, settings: SearchSettings, rng: np.random.Generator
) -> Candidates:
    """Lines 8 to 29: repeat guess, image, CNN and evaluation.

    All executions advance together, one guess each a round, so that the network reads them as one batch.
    Each execution has its own random stream, so the guesses are those of the listing run one by one.

    Parameters
    ----------
    reader : ResidualReader
        Network and torque.
    prepared : Prepared
        Signals.
    settings : SearchSettings
        Constants.
    rng : numpy.random.Generator
        Parent of the executions' streams.

    Returns
    -------
    Candidates
        Every physically possible estimate.
    """
    possible = FEASIBILITY[settings.feasibility]
    score = TorqueScorer(prepared.alpha, prepared.y_sub, settings.metric)
    streams = rng.spawn(settings.executions)  # line 13: for k_T = 1 to N_exe
    running = np.arange(settings.executions)  # lines 14, 15: n_e = 0, N_it = 0
    beta_m, origin, similarity = [np.empty((0, 9))], [np.empty(0, np.int64)], [np.empty(0)]  # line 11
    images_before = reader.images
    for _ in range(settings.inner_limit):  # lines 9, 10, 16: while n_e < u and N_it < L_exe
        if not running.size:
            break
        beta_n = np.stack([streams[k].uniform(settings.low, settings.high, 9) for k in running])  # line 17
        beta = reader.estimate(beta_n)  # lines 18 to 21
        ok = possible(beta)  # line 22; what fails is beta = 0 with n_e = 0 (lines 23, 24)
        n_e = np.zeros(len(beta))
        n_e[ok] = score(beta[ok]).total.mean(-1)  # lines 26, 27
        beta_m.append(beta[ok])  # line 29
        origin.append(running[ok])
        similarity.append(n_e[ok])
        running = running[n_e < settings.threshold]  # line 28 is the loop's own count
    images = reader.images - images_before
    return Candidates(np.concatenate(beta_m), np.concatenate(origin), np.concatenate(similarity), images)


def select(beta_m: Array, prepared: Prepared, settings: SearchSettings) -> Selected:
    """Lines 30 to 32: **high2sel** on the full-rate signals, then the levels of the input torque.

    Parameters
    ----------
    beta_m : array of shape (n, 9)
        Estimates in units of the largest torque.
    prepared : Prepared
        Signals.
    settings : SearchSettings
        Metric.

    Returns
    -------
    Selected
        The most similar set; all zeros with similarity 0, where line 11 starts, if no estimate was possible.
    """
    if not len(beta_m):
        return Selected(np.zeros(9), 0.0)
    r = prepared.regression
    similarity = TorqueScorer(r.tau / prepared.largest, r.y, settings.metric)(beta_m).total.mean(-1)
    best = int(similarity.argmax())
    beta_o = beta_m[best]  # line 30
    tau_r = rebuild_torque(r.y, beta_o)  # line 31
    # Line 32, beta_o max(tau_c) / (c_p max(tau_r)), with tau_c = c_p tau after line 6.
    tau_c = prepared.c_p * r.tau
    beta_o = beta_o * np.abs(tau_c).max() / (prepared.c_p * np.abs(tau_r).max())
    return Selected(prepared.recorded(beta_o), float(similarity[best]))
