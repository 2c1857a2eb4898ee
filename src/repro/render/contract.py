"""What a CSV must look like before it is drawn; anything else is refused in one line."""

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from repro.errors import InputError
from repro.model.parameters import Array

#: Points (x, y) of one curve, arrays of shape (n,).
Curve = tuple[Array, Array]


def check_table(frame: pd.DataFrame, text: Sequence[str] = (), numbers: Sequence[str] = ()) -> pd.DataFrame:
    """Check columns and values of a table."""
    wanted = (*text, *numbers)
    missing = [name for name in wanted if name not in frame.columns]
    if missing:
        raise InputError.at("header", f"no column {', '.join(missing)}", f"columns {', '.join(wanted)}")
    if frame.empty:
        raise InputError.at("rows", "none", "at least one")
    checked: dict[str, object] = {}
    for name in text:
        blank = frame[name].isna().to_numpy()
        if blank.any():
            raise InputError.at(f"line {_first_line(blank)}: {name}", "nothing", "text")
        checked[name] = frame[name].astype(str).to_numpy(dtype=object)
    for name in numbers:
        values = pd.to_numeric(frame[name], errors="coerce").to_numpy(dtype=np.float64, na_value=np.nan)
        wrong = ~np.isfinite(values)
        if wrong.any():
            found = frame[name].iloc[int(np.argmax(wrong))]
            raise InputError.at(f"line {_first_line(wrong)}: {name}", repr(found), "a finite number")
        checked[name] = values
    return pd.DataFrame(checked)


def _first_line(wrong: "np.ndarray[tuple[int], np.dtype[np.bool_]]") -> int:
    """Line of the CSV where `wrong` is first true; the header is line 1."""
    return int(np.argmax(wrong)) + 2


def check_names(found: pd.Series, allowed: Sequence[str], field: str) -> None:
    """Check that a column holds exactly the names it may hold."""
    present = [str(name) for name in found.unique()]
    for name in present:
        if name not in allowed:
            raise InputError.at(field, repr(name), f"one of {', '.join(allowed)}")
    for name in allowed:
        if name not in present:
            raise InputError.at(field, f"no {name!r}", f"all of {', '.join(allowed)}")


def check_range(frame: pd.DataFrame, columns: Sequence[str], low: float, high: float, meaning: str) -> None:
    """Check that columns stay within a range."""
    for name in columns:
        values = frame[name].to_numpy(dtype=np.float64)
        wrong = (values < low) | (values > high)
        if wrong.any():
            raise InputError.at(f"line {_first_line(wrong)}: {name}", f"{values[np.argmax(wrong)]:g}", meaning)


def flags(frame: pd.DataFrame, name: str) -> "np.ndarray[tuple[int], np.dtype[np.bool_]]":
    """Read a column of true and false, also written as 1 and 0."""
    words = check_table(frame, text=(name,))[name].str.lower()
    meaning = {"true": True, "false": False, "1": True, "0": False}
    known = words.isin(list(meaning)).to_numpy()
    if not known.all():
        found = repr(words.iloc[int(np.argmin(known))])
        raise InputError.at(f"line {_first_line(~known)}: {name}", found, "true or false")
    return np.array([meaning[word] for word in words], dtype=np.bool_)


def read_curves(
    frame: pd.DataFrame, panels: Mapping[str, Sequence[str]], rising: bool = True
) -> dict[str, dict[str, Curve]]:
    """Split a long table ``panel, series, x, y`` into curves."""
    table = check_table(frame, text=("panel", "series"), numbers=("x", "y"))
    check_names(table["panel"], list(panels), "panel")
    curves: dict[str, dict[str, Curve]] = {}
    for panel, series in panels.items():
        rows = table[table["panel"] == panel]
        check_names(rows["series"], series, f"panel {panel}: series")
        curves[panel] = {}
        for name in series:
            points = rows[rows["series"] == name]
            x, y = points["x"].to_numpy(), points["y"].to_numpy()
            place = f"panel {panel}, series {name}"
            if x.size < 2:
                raise InputError.at(place, f"{x.size} point", "at least two points")
            if rising and not (np.diff(x) > 0).all():
                line = int(points.index[int(np.argmin(np.diff(x) > 0)) + 1]) + 2
                raise InputError.at(f"line {line}: x", f"no rise in {place}", "x that rises from point to point")
            curves[panel][name] = (x, y)
    return curves


def dense(table: pd.DataFrame, axes: Sequence[str], values: Sequence[str], place: str) -> Array:
    """Fold a long table with integer indices into an array."""
    index = table[list(axes)].to_numpy(dtype=np.float64)
    if (index < 0).any() or (index != np.floor(index)).any():
        raise InputError.at(f"{place}: {', '.join(axes)}", "an index that is not", "whole numbers from 0")
    shape = tuple(int(n) for n in index.max(axis=0) + 1)
    whole = index.astype(np.intp)
    size = int(np.prod(shape))
    if len(whole) != size or len(np.unique(np.ravel_multi_index(tuple(whole.T), shape))) != size:
        expected = f"{' x '.join(str(n) for n in shape)} = {size}, each index once"
        raise InputError.at(f"{place}: {', '.join(axes)}", f"{len(whole)} rows", expected)
    array = np.empty((*shape, len(values)))
    array[tuple(whole.T)] = table[list(values)].to_numpy(dtype=np.float64)
    return array
