"""The result files of a run, and their numbers by what they are."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from repro.cnn.architecture import HISTORY_COLUMNS
from repro.errors import InputError
from repro.files import read_csv, read_rows

SIMILARITY = ("case", "method", "joint", "time", "frequency", "total")
SCORES = ("case", "method", "seed", "joint", "time", "frequency", "total")
PARAMETERS = ("case", "method", "parameter", "true", "estimate", "estimate_sd")

#: Result files by their path in the results folder, and the columns that each must have.
FILES: dict[str, tuple[str, ...]] = {
    "tables/table04.csv": PARAMETERS,
    "tables/table05.csv": PARAMETERS,
    "tables/table06.csv": SIMILARITY,
    "tables/table07.csv": SIMILARITY,
    "tables/table08.csv": SIMILARITY,
    "tables/table09.csv": PARAMETERS,
    "tables/table10.csv": SIMILARITY,
    "tables/stability.csv": ("method", "quantity", "value", "bound"),
    "model/training.csv": HISTORY_COLUMNS,
    "validation/numeric.csv": (*SCORES, "trajectory"),
    "validation/experiment.csv": SCORES,
}

#: Scores of every seed behind a table of medians, and the trajectory that the table is about.
_SEEDS = {
    "table04": ("validation/numeric.csv", "ID"),
    "table05": ("validation/numeric.csv", "ID"),
    "table06": ("validation/numeric.csv", "ID"),
    "table07": ("validation/numeric.csv", "validation"),
    "table10": ("validation/experiment.csv", ""),
}


@dataclass(frozen=True)
class Sample:
    """A number of a table, and its scatter over the seeds."""

    value: float
    std: float = 0.0
    seeds: int = 1


class Results:
    """Numbers of a results folder by what they are."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._frames = {name: read_csv(folder / name, columns) for name, columns in FILES.items()}

    def _rows(self, name: str, **wanted: object) -> pd.DataFrame:
        frame = self._frames[name]
        for column, value in wanted.items():
            frame = frame[frame[column] == value]
        if frame.empty:
            what = ", ".join(f"{column} {value}" for column, value in wanted.items())
            raise InputError.at(str(self._folder / name), f"no row of {what}", "one")
        return frame

    def _number(self, name: str, column: str, **wanted: object) -> float:
        row = self._rows(name, **wanted)
        cell = row[column].iloc[0]
        try:
            number = float(cell)
        except ValueError:
            number = np.nan
        if not np.isfinite(number):
            what = ", ".join(f"{key} {value}" for key, value in wanted.items())
            text = read_rows(self._folder / name)[row.index[0]][column]  # pandas reads n/a as NaN
            raise InputError.at(f"{self._folder / name}: {column} of {what}", text or "nothing", "a finite number")
        return number

    def _scores(self, table: str, **wanted: object) -> pd.DataFrame:
        """Scores of every seed behind rows of a table."""
        name, trajectory = _SEEDS[table]
        return self._rows(name, **wanted, **({"trajectory": trajectory} if trajectory else {}))

    def similarity(self, table: str, case: str, method: str, joint: int, quantity: str) -> Sample:
        """Similarity of a table, %."""
        row = {"case": case, "method": method, "joint": joint}
        value = 100.0 * self._number(f"tables/{table}.csv", quantity, **row)
        return _sample(value, 100.0 * self._scores(table, **row)[quantity]) if table in _SEEDS else Sample(value)

    def mean_total(self, table: str, method: str, cases: tuple[str, ...]) -> Sample:
        """Mean of the totals of both joints in some cases, %."""
        cells = [self.similarity(table, case, method, joint, "total").value for case in cases for joint in (1, 2)]
        scores = pd.concat([self._scores(table, case=case, method=method) for case in cases])
        return _sample(float(np.mean(cells)), 100.0 * scores.groupby("seed")["total"].mean())

    def parameter(self, table: str, case: str, method: str, name: str) -> tuple[float, Sample]:
        """True value of a parameter, and its estimate, SI units."""
        row = {"case": case, "method": method, "parameter": name}
        true, estimate, sd = (self._number(f"tables/{table}.csv", c, **row) for c in PARAMETERS[3:])
        seeds = self._scores(table, case=case, method=method)["seed"].nunique() if table in _SEEDS else 1
        return true, Sample(estimate, sd, seeds)

    def stability(self, quantity: str, column: str) -> float:
        """A number of the appendix for the arm behind the simulated board."""
        name = "tables/stability.csv"
        names = self._rows(name, method="appendix")["quantity"].astype(str)
        full = next((text for text in names if text.startswith(quantity)), quantity)
        return self._number(name, column, method="appendix", quantity=full)

    def loss(self) -> float:
        """Held-out loss at the end of the training."""
        step = self._frames["model/training.csv"]["step"].max()
        return self._number("model/training.csv", "test_loss", step=step)


def _sample(value: float, scores: pd.Series) -> Sample:
    return Sample(value, float(scores.std(ddof=1)), len(scores)) if len(scores) > 1 else Sample(value)
