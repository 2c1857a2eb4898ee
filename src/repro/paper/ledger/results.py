"""The result files that the ledger compares, read and checked."""

from pathlib import Path

import numpy as np
import pandas as pd

from repro.cnn.schedule import HISTORY_COLUMNS
from repro.errors import InputError
from repro.files import read_csv

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
    "table06": ("validation/numeric.csv", "ID"),
    "table07": ("validation/numeric.csv", "validation"),
    "table10": ("validation/experiment.csv", ""),
}


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
        cell = self._rows(name, **wanted)[column].iloc[0]
        try:
            number = float(cell)
        except ValueError:
            number = np.nan
        if not np.isfinite(number):
            what = ", ".join(f"{key} {value}" for key, value in wanted.items())
            raise InputError.at(f"{self._folder / name}: {column} of {what}", cell, "a finite number")
        return number

    def similarity(self, table: str, case: str, method: str, joint: int, quantity: str) -> tuple[float, float]:
        """Similarity of a table, and its standard deviation over the seeds, %."""
        row = {"case": case, "method": method, "joint": joint}
        value = self._number(f"tables/{table}.csv", quantity, **row)
        if table not in _SEEDS:
            return 100.0 * value, 0.0
        name, trajectory = _SEEDS[table]
        scores = self._rows(name, **row, **({"trajectory": trajectory} if trajectory else {}))[quantity]
        return 100.0 * value, 100.0 * float(scores.std(ddof=1)) if len(scores) > 1 else 0.0

    def totals(self, table: str, method: str, cases: tuple[str, ...]) -> list[tuple[float, float]]:
        """Totals of both joints of some cases, each with its spread over the seeds, %."""
        return [self.similarity(table, case, method, joint, "total") for case in cases for joint in (1, 2)]

    def parameter(self, table: str, case: str, method: str, name: str) -> tuple[float, float, float]:
        """True value of a parameter, its estimate and the estimate's standard deviation over the seeds, SI units."""
        row = {"case": case, "method": method, "parameter": name}
        true, estimate, sd = (self._number(f"tables/{table}.csv", c, **row) for c in PARAMETERS[3:])
        return true, estimate, sd

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
