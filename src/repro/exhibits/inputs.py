"""What the numbers of an exhibit are read from."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd
from matplotlib.figure import Figure

from repro.exhibits.markup import Table
from repro.pipeline.identified import read_scores
from repro.pipeline.job import Config

#: Files by the name of the input.
Inputs = Mapping[str, Sequence[Path]]

#: Columns of the scores of the experiment, and of the spread.
SCORES = ("case", "method", "seed", "joint", "time", "frequency", "total")


@dataclass(frozen=True)
class Made:
    """How an exhibit is made: its numbers from files and settings, and its drawing or layout from the numbers."""

    numbers: Callable[[Inputs, Config], pd.DataFrame]
    drawing: Callable[[pd.DataFrame], Figure] | Callable[[pd.DataFrame], Table]


#: By kind and name of the exhibit.
Family = Mapping[tuple[str, str], Made]


def arm_scores(inputs: Inputs) -> pd.DataFrame:
    """Scores of the arm's estimates."""
    return read_scores(inputs["scores"], SCORES)
