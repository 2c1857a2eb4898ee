"""Algorithm 1 with a CNN trained for this very motion, and its refinement.

The paper trains its network for one trajectory, by numeric substitution of random parameters into Eq. 1 (Section
IV-A). The same is done here with the motion that was measured: the regressor of the log takes the place of that of
Eq. 10. Torque and f of the image are both columns of the filtered regressor, subsampled: a long motion brought to 100
samples first, as line 7 has it, would no longer be the motion that made the torque.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import numpy as np
import torch

from repro.cnn.allocator import keep_blocks
from repro.cnn.architecture import NetworkSettings
from repro.cnn.checkpoint import load_network, save_network
from repro.cnn.dataset import DataSettings, SampledMotion
from repro.cnn.factored import FactoredCNN
from repro.cnn.schedule import TrainingSettings
from repro.cnn.train import fingerprint, train
from repro.errors import InputError
from repro.estimators.interface import Estimate, Method, NoSolutionError
from repro.identify.algorithm1 import Candidates, SearchSettings, search, select
from repro.identify.prepare import Prepared
from repro.identify.refinement import RefinementSettings, refine, restart
from repro.identify.residual import ResidualReader
from repro.regression.prepare import Regression
from repro.signals.dct import dct2sub
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
        Budget of the refinement.
    seed : int
        Of guesses and moves.
    threads : int
        Threads of torch.
    """

    cache: Path
    training: TrainingSettings = field(default_factory=lambda: TrainingSettings(steps=2500))
    data: DataSettings = field(default_factory=DataSettings)
    network: NetworkSettings = field(default_factory=NetworkSettings)
    search: SearchSettings = field(
        default_factory=lambda: SearchSettings(threshold=0.9237, feasibility="positive-definite")
    )
    refinement: RefinementSettings = field(default_factory=RefinementSettings)
    seed: int = 1
    threads: int = 2


Report = Callable[[int, int, str], None]


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
        They share the trained network through the cache.
    """
    estimates = {
        "algorithm1": ("Algorithm 1", partial(_literal, settings=settings, report=report)),
        "algorithm1+refinement": ("Algorithm 1 + refinement", partial(_refined, settings=settings, report=report)),
    }
    literal, refined = (
        Method(name, title, "leon2022cnn", estimate, claims_intervals=False, needs_all_samples=True)
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
    s = settings
    keep_blocks()
    torch.set_num_threads(s.threads)
    key = fingerprint(motion, s.data, s.network, s.training)[:24]
    kept, checkpoint = s.cache / f"{key}.safetensors", s.cache / f"{key}.checkpoint"
    if kept.exists():
        try:
            return load_network(kept, s.network)
        except InputError:
            kept.unlink()  # a damaged file of our own cache: it is made again
    s.cache.mkdir(parents=True, exist_ok=True)
    trained = train(
        motion, s.data, s.network, s.training, checkpoint, lambda d, n, loss: report(d, n, f"loss {loss:.2e}")
    )
    save_network(kept, trained.network, {"motion": key})
    checkpoint.unlink(missing_ok=True)
    return trained.network


def _subsampled(regression: Regression) -> tuple[SampledMotion, Prepared]:
    """What the network sees and what candidates are compared on."""
    if regression.t.size < SAMPLES:
        raise NoSolutionError(f"{regression.t.size} samples after filtering, fewer than the {SAMPLES} of an image")
    columns = dct2sub(np.moveaxis(regression.y, -1, 0), SAMPLES)  # (9, 2, M)
    y_sub = np.ascontiguousarray(np.moveaxis(columns, 0, -1))
    tau_sub = dct2sub(regression.tau, SAMPLES)
    largest = float(np.abs(tau_sub).max())
    r = regression
    prepared = Prepared(r.q, r.dq, r.ddq, r.tau, 1.0, largest, tau_sub / largest, y_sub, y_sub, r.y)
    return SampledMotion(y_sub, y_sub), prepared


def _search(
    regression: Regression, settings: NetworkSearch, report: Report
) -> tuple[ResidualReader, Prepared, Candidates]:
    motion, prepared = _subsampled(regression)
    reader = ResidualReader(trained_network(motion, settings, report), settings.data.image, prepared)
    return reader, prepared, search(reader, prepared, settings.search, stream(settings.seed, Stream.OWN_SEARCH))


def _literal(regression: Regression, settings: NetworkSearch, report: Report) -> Estimate:
    _, prepared, found = _search(regression, settings, report)
    chosen = select(found.beta, prepared, settings.search)
    met = int((found.similarity >= settings.search.threshold).sum())
    return Estimate(
        chosen.beta,
        (
            f"similarity {100.0 * chosen.similarity:.4g} %",
            f"{met} of {settings.search.executions} executions met the threshold of "
            f"{100.0 * settings.search.threshold:.4g} %",
        ),
    )


def _refined(regression: Regression, settings: NetworkSearch, report: Report) -> Estimate:
    reader, prepared, found = _search(regression, settings, report)
    rng = stream(settings.seed, Stream.OWN_REFINE)
    candidates = restart(reader, found.beta, settings.search, settings.refinement, rng)
    chosen, control = (
        select(
            refine(reader, candidates, prepared, settings.search, settings.refinement, rng, feed_back),
            prepared,
            settings.search,
        )
        for feed_back in (True, False)
    )
    return Estimate(
        chosen.beta,
        (
            f"similarity {100.0 * chosen.similarity:.4g} %; the same moves unread by the network reach "
            f"{100.0 * control.similarity:.4g} %",
        ),
    )
