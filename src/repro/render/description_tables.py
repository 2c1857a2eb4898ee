"""Tables that describe: related work (Table 1), dynamic parameters (2), the network (3), the metric search."""

import pandas as pd

from repro.exhibits.markup import Table, plain

#: Candidates listed of each factor; the chosen one is added if it is not among them.
_LISTED = 10


def characteristics(frame: pd.DataFrame) -> Table:
    """Characteristics of the network (Table 3)."""
    rows = [
        (plain(feature), plain(str(value))) for feature, value in frame[["feature", "value"]].itertuples(index=False)
    ]
    caption = plain("Characteristics of the convolutional neural network.")
    return Table("Table 3", "tab:table03", caption, "ll", (plain("Feature"), plain("Value")), [(None, rows)])
