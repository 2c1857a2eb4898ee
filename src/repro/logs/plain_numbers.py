"""Read a table of nothing but numbers at once: fast, because no cell needs to be examined by itself."""

from collections.abc import Sequence
from io import BytesIO
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from repro.model.parameters import Array

_NUMBERS = b"0123456789+-.eE"  # all that the cells may contain


def plain_numbers(
    path: Path, begin: int, separator: str, width: int, columns: Sequence[int]
) -> tuple[Array, NDArray[np.int64]] | None:
    """Read columns (k, N) from line `begin` on, NaN for empty cells, and the line of each row.

    None for a file with a quote, a blank, a word, an empty line, a row that is not `width` cells wide, or a cell that
    `float` refuses or makes infinite: such a file must be read cell by cell.
    """
    with path.open("rb") as file:
        above = b"".join(file.readline() for _ in range(begin - 1)).replace(b"\r\n", b"\n")
        rows = file.read().replace(b"\r\n", b"\n")
    rows += b"" if rows.endswith(b"\n") else b"\n"
    pattern = separator.encode() * (width - 1) + b"\n"
    if b"\r" in above or rows.translate(None, _NUMBERS) != pattern * rows.count(b"\n"):
        return None
    try:  # pandas gives the same bits as `float`
        frame = pd.read_csv(
            BytesIO(rows),
            sep=separator,
            header=None,
            usecols=sorted(set(columns)),
            dtype=np.float64,
            na_values=[""],
            keep_default_na=False,
            skip_blank_lines=False,
        )
    except ValueError:
        return None
    values = frame[list(columns)].to_numpy().T
    if np.isinf(values).any():
        return None
    return np.ascontiguousarray(values), np.arange(begin, begin + values.shape[1])
