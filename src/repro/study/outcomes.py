"""Outcomes of the study: how good each method's estimate of each arm in each cell is, also where it was not fitted."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from repro.fpga.frames import RADIANS_PER_COUNT
from repro.identification.scores import relative_rms
from repro.model.parameters import FEASIBILITY, Array
from repro.pipeline.experiment import Recording
from repro.pipeline.job import Config
from repro.pipeline.monte_carlo import Scores
from repro.pipeline.simulated_arms import run_loop
from repro.progress import over
from repro.settings import metric_settings, signal_settings
from repro.streams import Stream, stream
from repro.study.arms import excitation_config, least_squares_similarity, read_choice, specimens
from repro.study.design import jobs
from repro.study.readers import Readers, Reading

#: Digits that are kept.
DIGITS = 5


def run_job(job: str, choice: Path, training: Path, weights: Sequence[Path], config: Config) -> pd.DataFrame:
    """Record the arms of a job's cells, and identify each by every method."""
    own, rows, estimates = jobs(config)[job], [], list[tuple[Recording, Array, bool]]()
    c = excitation_config(config, own[0].excitation)
    program, kept = read_choice(choice, config, own[0].excitation)
    arms = kept[f"arms/{own[0].prior}"]
    readers = Readers(training, {path.stem: path for path in weights}, config, signal_settings(c))
    recorded = specimens(config, own, program, arms)
    for k, one in enumerate(over(recorded, f"identifying {len(recorded)} runs")):
        rng = stream(config["study"]["seed"], Stream.STUDY_SEARCH, one.labels["arm"])
        scores = Scores(one.recordings, c)
        on_id, *others = scores.regressions
        largest = float(np.abs(on_id.tau).max())  # N m, unit of priors and of errors of parameters
        least_squares = least_squares_similarity(one.recordings[0], c)
        searched = own[k // len(arms)].searched
        found = [Reading("true", one.true), *readers.read(one.recordings[0], searched, rng)]
        for reading in found:
            beta, row = reading.beta, {**one.labels, "method": reading.method, "least_squares": least_squares}
            row |= scores(beta, metric_settings(c))
            row["torque_error"] = float(np.mean([relative_rms(r, beta) for r in others]))
            row["parameter_error"] = float(np.sqrt(np.mean((beta - one.true) ** 2))) / largest
            rows.append({**row, **readers.judge(reading, one.true, largest, rng)})
            estimates.append((one.recordings[1], beta, searched))
    return pd.DataFrame(rows).assign(position_error=_position_errors(estimates, config)).round(DIGITS)


def _position_errors(estimates: Sequence[tuple[Recording, Array, bool]], config: Config) -> Array:
    """RMS difference of T1 as recorded and as Eq. 1 with the estimate moves in the same loop, rad; NaN if it cannot."""
    every, betas, searched = zip(*estimates, strict=True)
    # For time only cells that every method is run in.
    able = FEASIBILITY["positive-definite"](np.stack(betas)) & np.array(searched)
    errors = np.full(len(betas), np.nan)
    if not able.any():
        return errors
    motions = [motion for motion, possible in zip(every, able, strict=True) if possible]
    desired = np.stack([motion.program.q for motion in motions])
    position, _ = run_loop(config, np.stack(betas)[able], desired, "estimates", quick=True)
    apart = position * RADIANS_PER_COUNT - np.stack([motion.q for motion in motions])
    errors[able] = np.sqrt(np.mean(apart**2, axis=(1, 2)))
    return errors
