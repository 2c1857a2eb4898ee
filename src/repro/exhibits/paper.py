"""What the paper's own numbers say: the search for its metric, and its audit."""

import pandas as pd

from repro.exhibits.inputs import Family, Inputs, Made
from repro.files import read_csv
from repro.paper.audit import audit
from repro.render import audit_table, candidates, description_tables


def _search(inputs: Inputs) -> pd.DataFrame:
    return read_csv(inputs["search"][0], ("factor", "candidate", "rms_log_error_best", "chosen"))


def _candidates(inputs: Inputs) -> pd.DataFrame:
    found = _search(inputs).rename(columns={"rms_log_error_best": "rms_log_error"})
    return found[["factor", "candidate", "rms_log_error", "chosen"]]


MADE: Family = {
    ("table", "metric_search"): Made(lambda i, _: _search(i), description_tables.metric_search),
    ("figure", "metric_search"): Made(lambda i, _: _candidates(i), candidates.metric_search),
    ("table", "audit"): Made(lambda _, __: audit(), audit_table.audit),
}
