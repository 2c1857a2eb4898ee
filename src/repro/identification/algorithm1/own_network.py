"""Algorithm 1 with a CNN trained for this very motion, and its refinement.

The regressor of the log takes the place of that of Eq. 10, by whose numeric substitution the paper trains (Section
IV-A). Torque and f of the image are both columns of the filtered regressor, subsampled: a long motion brought to 100
samples first, as line 7 has it, would no longer be the motion that made the torque.
"""

import hashlib
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from pathlib import Path

import numpy as np
import torch

from repro.cnn.architecture import NetworkSettings, TrainingSettings
from repro.cnn.dataset import DataSettings, SampledMotion
from repro.cnn.network import FactoredCNN, load_network, on_this_processor, save_network
from repro.cnn.train import fingerprint, train
from repro.errors import InputError
from repro.identification.algorithm1.preprocessing import PreparedSignals
from repro.identification.algorithm1.refinement import Algorithm1, RefinementSettings
from repro.identification.algorithm1.search import ARM_THRESHOLD, SearchSettings
from repro.identification.method import Estimate, Method, NoSolutionError
from repro.identification.regression import Regression
from repro.signals.dct import dct2sub
from repro.signals.metric import UNIT_FREE_METRIC
from repro.streams import Stream, stream

SAMPLES = 100  # side of the image
DATA, NETWORK, REFINEMENT = DataSettings(), NetworkSettings(), RefinementSettings()
#: What is physically possible is a positive-definite M(q) and positive parameters.
SEARCH = SearchSettings(
    inner_limit=100, threshold=ARM_THRESHOLD, feasibility="positive-definite", metric=UNIT_FREE_METRIC
)


@dataclass(frozen=True)
class NetworkSearch:
    """Budgets of training and search."""

    cache: Path  # folder of trained networks, named by a hash of everything that decides them
    training: TrainingSettings
    search: SearchSettings = SEARCH
    refinement: RefinementSettings = REFINEMENT
    starts: int = 8  # of the refinement: on a short log three of ten end in a local optimum
    seed: int = 1  # of guesses and moves


Report = Callable[[int, int, str], None]


def methods(settings: NetworkSearch, report: Report) -> tuple[Method, Method]:
    """Make Algorithm 1 as published and with the refinement, which share one run."""
    run = lru_cache(maxsize=1)(partial(_run, settings=settings, report=report))
    method = partial(Method, citation="cnn_identification", claims_intervals=False, needs_all_samples=True)
    return (
        method("algorithm1", "Algorithm 1", estimate=lambda regression: run(regression)[0]),
        method("algorithm1+refinement", "Algorithm 1 + refinement", estimate=lambda regression: run(regression)[-1]),
    )


def trained_network(motion: SampledMotion, settings: NetworkSearch, report: Report) -> FactoredCNN:
    """Load the network of a motion from the cache, or train it, from its checkpoint if there is one, and store it."""
    training = replace(settings.training, precision=on_this_processor(settings.training.precision))
    torch.set_num_threads(1)  # sums of several threads are added in another order, and the seed gives another network
    arithmetic = (torch.__version__, torch.backends.cpu.get_cpu_capability())
    run = fingerprint(motion, DATA, NETWORK, training)
    key = hashlib.sha256(repr((run, arithmetic)).encode()).hexdigest()[:24]
    weights, checkpoint = settings.cache / f"{key}.safetensors", settings.cache / f"{key}.checkpoint"
    if weights.exists():
        try:
            return load_network(weights, NETWORK, precision=training.precision)
        except InputError:
            weights.unlink()  # a damaged file of our own cache
    settings.cache.mkdir(parents=True, exist_ok=True)
    network, _ = train(motion, DATA, NETWORK, training, checkpoint, lambda d, n, loss: report(d, n, f"loss {loss:.2e}"))
    save_network(weights, network, {"motion": key})
    checkpoint.unlink(missing_ok=True)
    return network


def _run(regression: Regression, settings: NetworkSearch, report: Report) -> list[Estimate]:
    """Run Algorithm 1, and its refinement, with the network of the regression's motion, both subsampled."""
    if regression.t.size < SAMPLES:
        raise NoSolutionError(f"{regression.t.size} samples after filtering, fewer than the {SAMPLES} of an image")
    columns = dct2sub(np.moveaxis(regression.y, -1, 0), SAMPLES)  # (9, 2, M)
    y_sub = np.ascontiguousarray(np.moveaxis(columns, 0, -1))
    tau_sub = dct2sub(regression.tau, SAMPLES)
    torque_scale = float(np.abs(tau_sub).max())
    signals = PreparedSignals(regression, 1.0, torque_scale, tau_sub / torque_scale, y_sub, y_sub)
    network = trained_network(SampledMotion(y_sub, y_sub), settings, report)
    algorithm1 = Algorithm1("published", network, DATA.image, settings.search, settings.refinement, settings.starts)
    streams = (stream(settings.seed, kind) for kind in (Stream.OWN_SEARCH, Stream.OWN_REFINE))
    found, met = algorithm1.run(signals, *streams)
    reached = {name: f"{100.0 * estimate.details['similarity']:.4g} %" for name, estimate in found.items()}
    threshold = f"the threshold of {100.0 * settings.search.threshold:.4g} %"
    executions = f"{met} of {settings.search.executions} executions met {threshold}"
    results = [replace(found["algorithm1"], notes=(f"similarity {reached['algorithm1']}", executions))]
    if settings.refinement.passes:
        refined, control = (f"algorithm1+{step}" for step in ("refinement", "local-search"))
        note = f"similarity {reached[refined]}; the same moves unread by the network reach {reached[control]}"
        results.append(replace(found[refined], notes=(note,)))
    return results
