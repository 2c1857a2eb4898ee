"""Every specimen of the spread identified and scored."""

from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from repro.identification.algorithm1.refinement import Algorithm1
from repro.model.parameters import Array
from repro.pipeline.experiment_runs import identify_recording, least_squares_of, score_runs
from repro.pipeline.job import Config
from repro.pipeline.spread import chatters, read_spread
from repro.progress import Progress
from repro.settings import metric_settings, signal_settings


def score_specimens(
    networks: Sequence[Algorithm1], recordings: Path, index: int, tau_mean: Array, config: Config
) -> pd.DataFrame:
    """Similarity of every method on every motion of every specimen, for identification duration `index`.

    Columns ``case, joint, method, duration, arm, chatter, seed, time, frequency, total``.
    """
    signals, duration = signal_settings(config), config["spread"]["durations_s"][index]
    specimens = read_spread(recordings, config, index)
    progress = Progress(f"spread, identification of {duration:.4g} s")
    frames = []
    for k, one in enumerate(specimens):
        recorded = one.recordings["ID"]
        runs = [identify_recording(each, recorded, tau_mean, signals, one.seed, one.true) for each in networks]
        runs.append({**least_squares_of(recorded, signals, one.true), "seed": one.seed})
        scores = score_runs(runs, list(one.recordings.values()), signals, metric_settings(config))
        frames.append(scores.assign(duration=duration, arm=one.arm, chatter=int(chatters(recorded))))
        progress(k + 1, len(specimens))
    table = pd.concat(frames, ignore_index=True)
    return table[["case", "joint", "method", "duration", "arm", "chatter", "seed", "time", "frequency", "total"]]
