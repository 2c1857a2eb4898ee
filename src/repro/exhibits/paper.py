"""Tables and figures about the paper's own numbers: the search for its metric, and its audit."""

import pandas as pd

from repro.exhibits.inputs import Family, Inputs, Made
from repro.files import read_csv
from repro.paper.audit import audit
from repro.render import audit_table, candidates


def _search(inputs: Inputs) -> pd.DataFrame:
    return read_csv(inputs["search"][0], ("factor", "candidate", "rms_log_error_best", "chosen"))


def _motions(inputs: Inputs) -> pd.DataFrame:
    return read_csv(inputs["motions"][0], ("samples", "bandwidth", "bounds_satisfied", "chosen"))


def _candidates(inputs: Inputs) -> pd.DataFrame:
    table = _search(inputs).rename(columns={"rms_log_error_best": "rms_log_error"})
    return table[["factor", "candidate", "rms_log_error", "chosen"]]


MADE: Family = {
    ("table", "metric_search"): Made(lambda i, _: _search(i), candidates.ranking_table),
    ("table", "metric_motions"): Made(lambda i, _: _motions(i), candidates.motion_table),
    ("figure", "metric_search"): Made(lambda i, _: _candidates(i), candidates.metric_search),
    ("table", "audit"): Made(lambda _, __: audit(), audit_table.audit),
}
