"""Algorithm 1 and least squares over the accepted experiments, by the number of guesses."""

from collections.abc import Sequence
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from repro.config.model import Configuration
from repro.config.sections import of_network
from repro.experiments.accepted import GUESSES, read_accepted
from repro.experiments.identifications import prepare_recording
from repro.experiments.networks import algorithm1_of, for_the_arm
from repro.identification.algorithm1.search import ResidualEstimator, search_in_turn, select
from repro.identification.least_squares import METHODS
from repro.identification.method import BASELINES
from repro.model.parameters import Array
from repro.progress import Progress
from repro.signals.metric import TorqueScorer
from repro.signals.programs import PROGRAMS
from repro.streams import Stream, stream

#: Networks whose searches an experiment has in detail, each a single change, and the place of the weights they read.
DETAILED = {"published": 0, "desired": 0, "tracked-measured": 1}


def search_accepted(
    number: int, experiments: Path, recordings: Path, weights: Sequence[Path], config: Configuration
) -> pd.DataFrame:
    """Scores of one experiment: least squares, the true parameters, and Algorithm 1 within each budget of guesses.

    An experiment in detail also has the further budgets with the first seed, and the extensions that the weights are
    given for.
    """
    a, metric = config.accepted, config.metric
    place, experiment = next(
        (k, one) for k, one in enumerate(read_accepted(experiments, recordings, config)) if one.number == number
    )
    signals, recorded = experiment.config.signals, experiment.recordings
    regressions = [recording.regression(signals) for recording in recorded]
    scorers = [TorqueScorer(r.tau, r.y, metric) for r in regressions]
    rows: list[dict[str, Any]] = []

    def add(beta: Array, **labels: Any) -> None:  # noqa: ANN401
        for case, scorer in zip(PROGRAMS, scorers, strict=True):
            s = scorer(beta)
            own = {"experiment": number, "unit": signals.frequency_reading, **labels, "case": case}
            for j in range(2):
                values = {"time": s.time[j], "frequency": s.frequency[j], "total": s.total[j]}
                rows.append({**own, "joint": j + 1, **values})

    none = {"seed": 0, "guesses": 0, "met": 0, "similarity": np.nan}
    for name, method in BASELINES.items():
        add(METHODS[method].estimate(regressions[0]).beta, method=name, **none)
    add(experiment.true, method="true", **none)
    detailed = place < a.detailed_experiments
    networks = [name for name, file in DETAILED.items() if file < len(weights)] if detailed else ["published"]
    for name, seed in product(networks, a.seeds):
        own = of_network(config, name)
        algorithm1 = for_the_arm(algorithm1_of(name, weights[DETAILED[name]], own), own)
        method = "algorithm1" if name == "published" else f"algorithm1+{name}"
        further = a.further_guesses if detailed and seed == a.seeds[0] else []
        budgets = [*a.guesses, *further]
        prepared = prepare_recording(recorded[0], None, signals, algorithm1.search.image_motion)
        estimator = ResidualEstimator(algorithm1.network, algorithm1.image, prepared)
        progress = Progress(f"experiment {number}, {method}, seed {seed}")
        found = search_in_turn(estimator, prepared, algorithm1.search, stream(seed, Stream.LONG_SEARCH), budgets)
        for k, (budget, candidates) in enumerate(zip(budgets, found, strict=True)):
            progress(k + 1, len(budgets))
            best = select(candidates.beta, prepared, algorithm1.search)
            labels = {"guesses": budget, "met": candidates.met, "similarity": best.similarity}
            add(best.beta, method=method, seed=seed, **labels)
    return pd.DataFrame(rows)[list(GUESSES)]
