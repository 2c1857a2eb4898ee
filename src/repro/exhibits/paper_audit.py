"""The paper's own numbers: the search for its metric, and its audit."""

import pandas as pd

from repro.exhibits.declare import CLAIMS, METRIC, Inputs, figure, table
from repro.files import read_csv
from repro.paper.audit import audit
from repro.pipeline.job import Config
from repro.render import audit_table, candidates


def _search(inputs: Inputs) -> pd.DataFrame:
    return read_csv(inputs["search"][0], ("factor", "candidate", "rms_log_error_best", "chosen"))


@table("metric_search", "Ranking of the formulas of metr2ev", METRIC, candidates.ranking_table, inputs=("search",))
def metric_search_table(inputs: Inputs, _: Config) -> pd.DataFrame:
    """Ranking of candidate formulas of metr2ev by their rms log error against the published Table 7, with the range of
    ranks if one of the four arms is left out.
    """
    return _search(inputs)


@table(
    "metric_motions",
    "Random motions that explain Table 7",
    METRIC,
    candidates.motion_table,
    target="metric_motions",
    inputs=("search",),
)
def metric_motions(inputs: Inputs, _: Config) -> pd.DataFrame:
    """Random motions of different length and bandwidth: their mean-square torque, the bounds from the published Table 7
    that it satisfies, and the rms log errors of the formulas of metr2ev against that table.
    """
    return read_csv(inputs["motions"][0], ("samples", "bandwidth", "bounds_satisfied", "chosen"))


@figure("metric_search", "Candidates for the metric's formula", METRIC, candidates.metric_search, inputs=("search",))
def metric_search_figure(inputs: Inputs, _: Config) -> pd.DataFrame:
    """How well candidate formulas of metr2ev explain the Time and Freq. rows of the published Table 7, given the
    published parameters of Tables 4 and 5.
    """
    table = _search(inputs).rename(columns={"rms_log_error_best": "rms_log_error"})
    return table[["factor", "candidate", "rms_log_error", "chosen"]]


@table("audit", "Audit of the paper", CLAIMS, audit_table.audit, target="audit")
def audit_findings(_: Inputs, __: Config) -> pd.DataFrame:
    """Every check of the paper against itself: printed numbers and formulas, each with its arithmetic. Our results play
    no part; where the extraction of the paper's text may be at fault, the note says so.
    """
    return audit()
