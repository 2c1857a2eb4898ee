"""The headline rows under both time factors of the metric."""

import pandas as pd

from repro.config.model import Configuration
from repro.drawing.markup import layout, plain, several
from repro.exhibits.declare import ARM, Inputs, table
from repro.exhibits.result_tables import by_method
from repro.experiments import summary
from repro.experiments.arm import read_recordings
from repro.experiments.identifications import read_identifications

_FORMULAS = {"mean-square": "mean square", "energy": "energy ratio"}
_MEANS = ("N1-N4, ID", "N1-N4, validation", "ID, joint 1", "ID, joint 2", "T1 to T4", "Freq., ID", "Freq., T1 to T4")


@table(
    "Headline rows under both time factors",
    layout(
        "The same estimates under both time factors of metr2ev: mean totals of N1 to N4 on the identification and the "
        "validation trajectory, totals of the simulated arm on ID and their mean over T1 to T4, and the mean frequency "
        "factor, which both share; medians over the seeds, %. Methods of the arm alone have no numeric tests.",
        ("Time factor", "l", lambda row: plain(_FORMULAS[row["formula"]])),
        *several(_MEANS, summary.BOTH_METRICS[2:], 2, 100.0),
        blocks=by_method,
    ),
    category="Experiment (simulated)",
    inputs=("headline",),
    sections=(*ARM, "metric", "numeric"),
)
def both_metrics(inputs: Inputs, config: Configuration) -> pd.DataFrame:
    """The headline rows of the numeric tests and of the simulated arm under both time factors of metr2ev, from the same
    estimates.
    """
    numeric, arm = (read_identifications(inputs[name]) for name in ("numeric", "arm"))
    return summary.both_metrics(numeric, arm, read_recordings(inputs["captures"], config), config)
