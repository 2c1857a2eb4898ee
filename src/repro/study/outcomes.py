"""Outcomes of the study: how good each method's estimate of each arm in each cell is, also where it was not fitted."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from repro.fpga.controller import simulate
from repro.fpga.frames import RADIANS_PER_COUNT
from repro.fpga.plant import Plant
from repro.identification.scores import relative_rms
from repro.model.parameters import FEASIBILITY, NAMES, Array
from repro.pipeline.experiment import control_constants
from repro.pipeline.job import Config
from repro.progress import Progress
from repro.settings import metric_settings, signal_settings
from repro.signals.metric import TorqueScorer
from repro.streams import Stream, stream
from repro.study.arms import Specimen, read_arms, read_excitation, specimens
from repro.study.design import FACTORS, RANKS, jobs
from repro.study.motions import excitation_config
from repro.study.readers import Readers, Reading

#: Digits that are kept.
DIGITS = 5


def run_job(job: str, choice: Path, training: Path, weights: Sequence[Path], config: Config) -> pd.DataFrame:
    """Record the arms of a job's cells, and identify each by every method."""
    own = jobs(config)[job]
    excitation, prior = own[0].excitation, own[0].prior
    c = excitation_config(config, excitation)
    program, arms = read_excitation(choice, config, excitation), read_arms(choice, prior)
    readers = Readers(training, {path.stem: path for path in weights}, config, signal_settings(c))
    recorded, rows, estimates = specimens(config, own, program, arms), [], list[tuple[Specimen, Array]]()
    progress = Progress(f"identifying {len(recorded)} runs")
    for k, one in enumerate(recorded):
        rng = stream(config["study"]["seed"], Stream.STUDY_SEARCH, one.arm)
        scores, cell = _Scorer(one, c), {name: getattr(one.cell, name) for name in FACTORS}
        found = [Reading("true", one.true), *readers.read(one.recordings[0], one.cell.searched, rng)]
        for reading in found:
            claimed = readers.judge(reading, one.true, scores.largest, rng)
            below = np.full(len(NAMES), np.nan) if claimed is None else claimed.below_truth
            nearer, contraction = (np.nan, np.nan) if claimed is None else (claimed.nearer, claimed.contraction)
            claim = {"contraction": contraction, "nearer": nearer, **dict(zip(RANKS, below.tolist(), strict=True))}
            rows.append({**cell, "arm": one.arm, "method": reading.method, **scores(reading.beta), **claim})
            estimates.append((one, reading.beta))
        progress(k + 1, len(recorded))
    return pd.DataFrame(rows).assign(position_error=_position_errors(estimates, config)).round(DIGITS)


class _Scorer:
    """Scores of estimates on all recordings of one arm."""

    def __init__(self, one: Specimen, config: Config) -> None:
        self._one = one
        self._regressions = [recording.regression(signal_settings(config)) for recording in one.recordings]
        #: Largest filtered torque on the excitation, N m: unit of priors and of errors of parameters.
        self.largest = float(np.abs(self._regressions[0].tau).max())
        self._similarities = [TorqueScorer(r.tau, r.y, metric_settings(config)) for r in self._regressions]

    def __call__(self, beta: Array) -> dict[str, float]:
        """Similarity on the excitation and on T1 to T4, torque error there, and error of the parameters."""
        totals = [float(similarity(beta).total.mean()) for similarity in self._similarities]
        errors = [float(np.mean(relative_rms(r, beta))) for r in self._regressions[1:]]
        return {
            "least_squares": self._one.least_squares,
            "id": totals[0],
            "validation": float(np.mean(totals[1:])),
            "torque_error": float(np.mean(errors)),
            "parameter_error": float(np.sqrt(np.mean((beta - self._one.true) ** 2))) / self.largest,
        }


def _position_errors(estimates: Sequence[tuple[Specimen, Array]], config: Config) -> Array:
    """RMS difference of T1 as recorded and as Eq. 1 with the estimate moves in the same loop, rad; NaN if it cannot.

    Only of cells that every method is run in, for time.
    """
    beta = np.stack([beta for _, beta in estimates])
    able = FEASIBILITY["positive-definite"](beta) & np.array([one.cell.searched for one, _ in estimates])
    errors = np.full(len(beta), np.nan)
    if not able.any():
        return errors
    motions = [one.recordings[1] for (one, _), possible in zip(estimates, able, strict=True) if possible]
    plant = Plant(beta[able], config["signals"]["sampling_period_s"], quick=True)
    progress = Progress(f"simulating {len(motions)} estimates")
    with np.errstate(over="ignore", invalid="ignore"):
        desired = np.stack([motion.program.q for motion in motions])
        position, _ = simulate(plant, control_constants(config), desired, progress)
    apart = position * RADIANS_PER_COUNT - np.stack([motion.q for motion in motions])
    errors[able] = np.sqrt(np.mean(apart**2, axis=(1, 2)))
    return errors
