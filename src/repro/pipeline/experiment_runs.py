"""Identifications and scores of the experiment: runs on a recording, and runs and scores read back from files."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from repro.documents import read_json
from repro.errors import InputError
from repro.files import read_csv
from repro.identification.algorithm1.preprocessing import PreparedSignals, derivatives, prepare
from repro.identification.algorithm1.search import ImageMotion
from repro.identification.least_squares import METHODS
from repro.identification.method import BASELINES, as_json
from repro.identification.scores import score
from repro.model.parameters import NAMES, Array
from repro.pipeline.experiment import Recording
from repro.signals.dct import SignalSettings
from repro.signals.metric import MetricSettings, metr2ev
from repro.streams import Stream, stream

if TYPE_CHECKING:
    from repro.identification.algorithm1.refinement import Algorithm1

#: The one case of the experiment's identifications: parameters come from this motion.
CASE = "ID"


def prepare_recording(
    recording: Recording, tau_mean: Array, signals: SignalSettings, image_motion: ImageMotion = "measured"
) -> PreparedSignals:
    """Lines 1 to 12 of Algorithm 1 for a recording of any duration."""
    n1, n2 = recording.program.n1, recording.program.n2
    n, m = n2 - n1, tau_mean.shape[1]
    phase = (np.arange(n) + 0.5) * m / n - 0.5
    mean = np.stack([np.interp(phase, np.arange(m), joint) for joint in tau_mean])
    shown = None
    if image_motion == "desired":
        q, dq, ddq = (x[:, n1:n2] for x in derivatives(recording.program.q, signals))
        shown = q, dq, ddq
    return prepare(recording.regression(signals), mean, signals, m / n, shown)


def identify_recording(
    algorithm1: "Algorithm1", recording: Recording, tau_mean: Array, signals: SignalSettings, seed: int, true: Array
) -> dict[str, Any]:
    """Identify one recording by Algorithm 1, by its refinement, and by the refinement's controls."""
    prepared = prepare_recording(recording, tau_mean, signals, algorithm1.search.image_motion)
    kinds = (Stream.EXPERIMENT_SEARCH, Stream.EXPERIMENT_REFINE, Stream.UNIFORM_SEARCH)
    found, met = algorithm1.run(prepared, *(stream(seed, kind) for kind in kinds))
    arm = {"true": true.tolist(), "executions_over_threshold": met, "methods": as_json(found)}
    return {"variant": algorithm1.variant, "seed": seed, "arms": {CASE: arm}}


def least_squares_of(recording: Recording, signals: SignalSettings, true: Array) -> dict[str, Any]:
    """What Algorithm 1 is held against, and the parameters that the arm has.

    Each is the method that a user's own arm is identified by.
    """
    regression = recording.regression(signals)
    methods = as_json({name: METHODS[solver].estimate(regression) for name, solver in BASELINES.items()})
    methods["true"] = {"beta": true.tolist()}
    return {"variant": "least-squares", "seed": 0, "arms": {CASE: {"true": true.tolist(), "methods": methods}}}


def score_runs(
    runs: Sequence[Mapping[str, Any]],
    recordings: Sequence[Recording],
    signals: SignalSettings,
    metric: MetricSettings,
) -> pd.DataFrame:
    """Similarity of measured and rebuilt torque for every run and motion."""
    frames = []
    for recording in recordings:
        r = recording.regression(signals)
        for run in runs:
            scores = score(r.y, r.tau, run["arms"][CASE]["methods"], metric)
            frames.append(scores.assign(case=recording.program.name, seed=run["seed"]))
    columns = ["case", "method", "seed", "joint", "time", "frequency", "total"]
    return pd.concat(frames, ignore_index=True)[columns]


def tracking(recording: Recording, metric: MetricSettings) -> pd.DataFrame:
    """How well the arm followed the identification trajectory (Table 8), in the columns of `score_runs`."""
    proper = slice(recording.program.n1, recording.program.n2)
    s = metr2ev(recording.program.q[:, proper], recording.q[:, proper], metric)
    rows = [("tracking", "pd", 0, j + 1, s.time[j], s.frequency[j], s.total[j]) for j in (0, 1)]
    return pd.DataFrame(rows, columns=["case", "method", "seed", "joint", "time", "frequency", "total"])


SCORE_COLUMNS = ("case", "method", "seed", "trajectory", "joint", "time", "frequency", "total")


def _nine(value: object) -> bool:
    """Whether a value read from JSON is a parameter set."""
    return isinstance(value, list) and len(value) == len(NAMES) and all(isinstance(x, int | float) for x in value)


def _check_arms(path: Path, arms: object) -> None:
    """Refuse arms without true parameters or estimates, by the field at fault."""
    if not isinstance(arms, dict) or not arms:
        raise InputError.at(f"{path}: arms", "no arm", "at least one")
    for case, arm in arms.items():
        if not isinstance(arm, dict) or not _nine(arm.get("true")):
            raise InputError.at(f"{path}: arms.{case}.true", "no parameter set", "nine numbers")
        methods = arm.get("methods")
        if not isinstance(methods, dict) or not methods:
            raise InputError.at(f"{path}: arms.{case}.methods", "no method", "at least one")
        for method, estimate in methods.items():
            if not isinstance(estimate, dict) or not _nine(estimate.get("beta")):
                raise InputError.at(f"{path}: arms.{case}.methods.{method}.beta", "no parameter set", "nine numbers")


def read_identifications(paths: Sequence[Path | str]) -> list[dict[str, Any]]:
    """Results of `repro.pipeline.numeric.identify_arms`, checked for what later stages need."""
    runs = []
    for path in map(Path, paths):
        run = read_json(path)
        if not isinstance(run, dict) or not {"seed", "variant", "arms"} <= run.keys():
            raise InputError.at(str(path), "no identification result", "fields seed, variant, arms")
        _check_arms(path, run["arms"])
        runs.append(run)
    return runs


def every_seed(runs: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Runs with those that have no seed of their own (seed 0 of variant least-squares) repeated for each seed."""
    seeds = sorted({run["seed"] for run in runs if run["variant"] != "least-squares"}) or [0]
    spread = [{**run, "seed": seed} for run in runs if run["variant"] == "least-squares" for seed in seeds]
    return [dict(run) for run in runs if run["variant"] != "least-squares"] + spread


def read_scores(paths: Sequence[Path], columns: tuple[str, ...] = SCORE_COLUMNS) -> pd.DataFrame:
    """Scores of one or more network variants in one table."""
    frames = [read_csv(path, columns) for path in paths]
    for path, frame in zip(paths, frames, strict=True):
        for column in ("time", "frequency", "total"):
            wrong = ~pd.to_numeric(frame[column], errors="coerce").between(0, 1)
            if wrong.any():
                line = int(wrong.to_numpy().argmax()) + 2
                found = frame[column][wrong].iloc[0]
                raise InputError.at(f"{path}: line {line}: {column}", found, "a number from 0 to 1")
    return pd.concat(frames, ignore_index=True)
