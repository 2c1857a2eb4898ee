"""Comparison of a result with an earlier one: each parameter's change, and whether the intervals explain it."""

from pathlib import Path

import numpy as np

from repro.documents import read_json
from repro.fitting.prior import read_result
from repro.fitting.result import Change, Result


def changes_since(path: Path, result: Result) -> tuple[Change, ...]:
    """Compare the recommended parameters with those of a ``parameters.json``; InputError if it is none."""
    changes = []
    for now, before in zip(result.best.parameters, read_result(str(path), read_json(path)), strict=True):
        estimate, agree = float(before["estimate"]), None
        if None not in (now.low, now.high, before.get("low"), before.get("high")):
            # Both are 95 % intervals, so that the difference of the estimates has the root of the sum of squares.
            widths = (now.high - now.low, before["high"] - before["low"])  # type: ignore[operator]
            agree = bool(abs(now.estimate - estimate) <= 0.5 * np.hypot(*widths))
        changes.append(Change(now.name, now.unit, estimate, now.estimate, agree))
    return tuple(changes)
