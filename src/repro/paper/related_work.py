"""The cited works that Section I-A compares (``related_work.csv``): the facts of Table 1.

The paper's own Table 1 is an image, so ours is rebuilt from the text of Section I-A, one row for each of the works
[11] to [28] and one for the article itself. What the text does not say is ``not stated``. It says of works based on
LS and WLS that they need an optimised trajectory, of "some" optimisation methods that they do, and of the article
that it does not; of any other work it is silent.
"""

import re
from pathlib import Path

import pandas as pd

from repro.errors import InputError
from repro.files import read_csv

COLUMNS = ("reference", "robot", "dof", "method", "identified", "optimisation", "set_apart")
RELATED_WORK_FILE = Path(__file__).with_name("related_work.csv")

#: Cited works of Section I-A, and the article.
REFERENCES = (*(f"[{number}]" for number in range(11, 29)), "this article")

NOT_STATED = "not stated"
_DOF = re.compile(rf"[1-9]\d*(, [1-9]\d*)*|{NOT_STATED}")
_LEAST_SQUARES = re.compile(r"\bW?LS\b")


def load_related_work(path: Path = RELATED_WORK_FILE) -> pd.DataFrame:
    """Read and check the related work."""
    table = read_csv(path, COLUMNS)[list(COLUMNS)]
    for line, row in enumerate(table.itertuples(index=False), start=2):
        for name, value in zip(COLUMNS, row, strict=True):
            if pd.isna(value) or not str(value).strip():
                raise InputError.at(f"{path}: line {line}: {name}", "nothing", "text")
    table = table.astype(str)
    found = tuple(table["reference"])
    if found != REFERENCES:
        wrong = next((f for f, r in zip(found, REFERENCES, strict=False) if f != r), f"{len(found)} rows")
        raise InputError.at(f"{path}: reference", wrong, f"{', '.join(REFERENCES)}, in this order")
    for line, row in enumerate(table.itertuples(index=False), start=2):
        if not _DOF.fullmatch(str(row.dof)):
            raise InputError.at(f"{path}: line {line}: dof", repr(row.dof), f"whole numbers or {NOT_STATED}")
        for name, allowed in (("optimisation", ("yes", "no", NOT_STATED)), ("set_apart", ("yes", "no"))):
            if getattr(row, name) not in allowed:
                raise InputError.at(f"{path}: line {line}: {name}", repr(getattr(row, name)), " or ".join(allowed))
        if _LEAST_SQUARES.search(str(row.method)) and row.optimisation != "yes":
            expected = "yes, as Section I-A says of LS and WLS"
            raise InputError.at(f"{path}: line {line}: optimisation", repr(row.optimisation), expected)
    return table
