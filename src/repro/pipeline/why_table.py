"""Table of the steps from the ideal case to the recording; `repro.pipeline.why` runs the searches."""

import pandas as pd


def why_table(explained: pd.DataFrame) -> pd.DataFrame:
    """Medians over the seeds, and what each step costs."""
    groups = explained.groupby(["network", "step"], sort=False)
    table = groups[["total1", "total2", "error_uniform", "error_near"]].median()
    table[["spread1", "spread2"]] = groups[["total1", "total2"]].std(ddof=1).fillna(0.0).to_numpy()
    table["seeds"] = groups.size()
    mean = table[["total1", "total2"]].mean(axis=1)
    table["lost"] = mean.groupby("network", sort=False).transform(lambda totals: 0.0 - totals.diff().fillna(0.0))
    columns = ["network", "step", "seeds", "total1", "total2", "spread1", "spread2", "lost"]
    return table.reset_index()[[*columns, "error_uniform", "error_near"]]
