"""Identifications and scores read back from their files, checked for what later stages need."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from repro.documents import read_json
from repro.errors import InputError
from repro.files import read_csv
from repro.model.parameters import NAMES

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
