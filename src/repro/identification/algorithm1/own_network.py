"""Algorithm 1 with a CNN trained for this very motion, and its refinement.

The paper trains its network for one trajectory, by numeric substitution of random parameters into Eq. 1 (Section
IV-A). The same is done here with the motion that was measured: the regressor of the log takes the place of that of
Eq. 10. Torque and f of the image are both columns of the filtered regressor, subsampled: a long motion brought to 100
samples first, as line 7 has it, would no longer be the motion that made the torque.
"""

import hashlib
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from pathlib import Path

import numpy as np
import torch

from repro.cnn.architecture import NetworkSettings
from repro.cnn.dataset import DataSettings, SampledMotion
from repro.cnn.network import FactoredCNN, load_network, on_this_processor, save_network
from repro.cnn.schedule import TrainingSettings
from repro.cnn.train import fingerprint, train
from repro.errors import InputError
from repro.identification.algorithm1.listing import Prepared
from repro.identification.algorithm1.refinement import RefinementSettings
from repro.identification.algorithm1.run import Algorithm1
from repro.identification.algorithm1.search import SearchSettings
from repro.identification.method import Estimate, Method, NoSolutionError
from repro.identification.regression import Regression
from repro.signals.dct import dct2sub
from repro.signals.metric import UNIT_FREE_METRIC
from repro.streams import Stream, stream

#: Side of the image.
SAMPLES = 100


@dataclass(frozen=True)
class NetworkSearch:
    """Budgets of training and search.

    Attributes
    ----------
    cache : Path
        Folder of trained networks, named by a hash of all that made them.
    training : TrainingSettings
        Recipe and budget.
    data : DataSettings
        Distribution of the samples.
    network : NetworkSettings
        Sizes.
    search : SearchSettings
        Constants of Algorithm 1; what is physically possible is a positive-definite M(q) and positive parameters.
    refinement : RefinementSettings
        Budget of the refinement; no passes where it is not asked for.
    seed : int
        Of guesses and moves.
    """

    cache: Path
    training: TrainingSettings
    data: DataSettings = field(default_factory=DataSettings)
    network: NetworkSettings = field(default_factory=NetworkSettings)
    search: SearchSettings = field(
        default_factory=lambda: SearchSettings(
            threshold=0.9237, feasibility="positive-definite", metric=UNIT_FREE_METRIC
        )
    )
    refinement: RefinementSettings = field(default_factory=lambda: RefinementSettings(starts=8))
    seed: int = 1


Report = Callable[[int, int, str], None]
Run = Callable[[Regression], tuple[dict[str, Estimate], int]]


def methods(settings: NetworkSearch, report: Report) -> tuple[Method, Method]:
    """Algorithm 1 as published, and with the refinement.

    Parameters
    ----------
    settings : NetworkSearch
        Budgets.
    report : callable
        Called with steps of training done and in all, and a note.

    Returns
    -------
    tuple of 2 Method
        They share one run.
    """
    run = lru_cache(maxsize=1)(partial(_run, settings=settings, report=report))  # once for both
    estimates = {
        "algorithm1": ("Algorithm 1", partial(_literal, run=run, search=settings.search)),
        "algorithm1+refinement": ("Algorithm 1 + refinement", partial(_refined, run=run)),
    }
    literal, refined = (
        Method(name, title, "cnn_identification", estimate, claims_intervals=False, needs_all_samples=True)
        for name, (title, estimate) in estimates.items()
    )
    return literal, refined


def trained_network(motion: SampledMotion, settings: NetworkSearch, report: Report) -> FactoredCNN:
    """The network of a motion: from the cache if it is there, else trained and put there.

    Parameters
    ----------
    motion : SampledMotion
        Subsampled regressors.
    settings : NetworkSearch
        Budgets; training continues from its checkpoint if it was stopped.
    report : callable
        Progress.

    Returns
    -------
    FactoredCNN
        Trained.
    """
    s = replace(settings, training=replace(settings.training, precision=on_this_processor(settings.training.precision)))
    torch.set_num_threads(1)  # sums of several threads are added in another order, and the seed gives another network
    key = _key(fingerprint(motion, s.data, s.network, s.training))
    kept, checkpoint = s.cache / f"{key}.safetensors", s.cache / f"{key}.checkpoint"
    if kept.exists():
        try:
            return load_network(kept, s.network, precision=s.training.precision)
        except InputError:
            kept.unlink()  # a damaged file of our own cache: it is made again
    s.cache.mkdir(parents=True, exist_ok=True)
    trained = train(
        motion, s.data, s.network, s.training, checkpoint, lambda d, n, loss: report(d, n, f"loss {loss:.2e}")
    )
    save_network(kept, trained.network, {"motion": key})
    checkpoint.unlink(missing_ok=True)
    return trained.network


def _key(run: str) -> str:
    """Name of a network in the cache: its training, and what computes it."""
    arithmetic = (torch.__version__, torch.backends.cpu.get_cpu_capability())
    return hashlib.sha256(repr((run, arithmetic)).encode()).hexdigest()[:24]


def _subsampled(regression: Regression) -> tuple[SampledMotion, Prepared]:
    """What the network sees and what candidates are compared on."""
    if regression.t.size < SAMPLES:
        raise NoSolutionError(f"{regression.t.size} samples after filtering, fewer than the {SAMPLES} of an image")
    columns = dct2sub(np.moveaxis(regression.y, -1, 0), SAMPLES)  # (9, 2, M)
    y_sub = np.ascontiguousarray(np.moveaxis(columns, 0, -1))
    tau_sub = dct2sub(regression.tau, SAMPLES)
    largest = float(np.abs(tau_sub).max())
    return SampledMotion(y_sub, y_sub), Prepared(regression, 1.0, largest, tau_sub / largest, y_sub, y_sub)


def _run(regression: Regression, settings: NetworkSearch, report: Report) -> tuple[dict[str, Estimate], int]:
    """Algorithm 1 with the network of the regression's motion."""
    motion, prepared = _subsampled(regression)
    network = trained_network(motion, settings, report)
    algorithm1 = Algorithm1("published", network, settings.data.image, settings.search, settings.refinement)
    streams = (stream(settings.seed, kind) for kind in (Stream.OWN_SEARCH, Stream.OWN_REFINE))
    return algorithm1.run(prepared, *streams)


def _literal(regression: Regression, run: Run, search: SearchSettings) -> Estimate:
    found, met = run(regression)
    estimate = found["algorithm1"]
    said = (
        f"similarity {100.0 * estimate.details['similarity']:.4g} %",
        f"{met} of {search.executions} executions met the threshold of {100.0 * search.threshold:.4g} %",
    )
    return replace(estimate, notes=said)


def _refined(regression: Regression, run: Run) -> Estimate:
    found, _ = run(regression)
    refined, control = (
        100.0 * found[f"algorithm1+{step}"].details["similarity"] for step in ("refinement", "local-search")
    )
    said = f"similarity {refined:.4g} %; the same moves unread by the network reach {control:.4g} %"
    return replace(found["algorithm1+refinement"], notes=(said,))
