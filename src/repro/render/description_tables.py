"""Tables that describe: related work (Table 1), dynamic parameters (2), the network (3), the metric search."""

import pandas as pd

from repro.exhibits.markup import EMPTY, Table, Text, formula, number, plain, unit

#: Candidates listed of each factor; the chosen one is added if it is not among them.
_LISTED = 10

_SET_APART = Text(r"$^{\dagger}$", "\N{DAGGER}")


def related_work(frame: pd.DataFrame) -> Table:
    """Related work of Section I-A and the article (Table 1)."""
    columns = ["reference", "robot", "dof", "method", "identified", "optimisation", "set_apart"]
    rows = []
    for reference, robot, dof, *cells, apart in frame[columns].itertuples(index=False):
        work = plain(reference)
        work = Text(f"{{{work.tex}}}", work.md)  # LaTeX would read a bracket at the start of a row as an option
        freedom = plain("\N{EN DASH}" if dof == "not stated" else dof)
        rows.append((work + _SET_APART if apart == "yes" else work, plain(robot), freedom, *map(plain, cells)))
    caption = plain(
        "Related work and this article, rebuilt from Section I-A (the paper's own Table 1 is an image). Optimisation: "
        "whether an optimised trajectory is needed; Section I-A says so of works based on least squares (LS, weighted "
        "WLS) and of some optimisation methods, without naming these. FFNN: feed-forward, RBNN: radial basis neural "
        "network; LSTM: long short-term memory; MLP: multi-layer perceptron; KF: Kalman filter; "
        "\N{EN DASH}: not stated."
    )
    caption += Text(" ", " ") + _SET_APART + Text(" ", " ") + plain("Set apart in Section I-A by its contributions.")
    header = tuple(plain(n) for n in ("Work", "Robot", "DoF", "Method", "Identified", "Optimisation"))
    return Table("Table 1", "tab:table01", caption, "llllll", header, [(None, rows)])


def parameters(frame: pd.DataFrame) -> Table:
    """Dynamic parameters (Table 2)."""
    columns = ["parameter", "description", "expression", "unit"]
    rows = [
        (formula(name), plain(description), formula(expression), unit(si))
        for name, description, expression, si in frame[columns].itertuples(index=False)
    ]
    header = tuple(plain(name) for name in ("Parameter", "Description", "Expression", "Unit"))
    return Table("Table 2", "tab:table02", plain("Dynamic parameters of the arm."), "llll", header, [(None, rows)])


def characteristics(frame: pd.DataFrame) -> Table:
    """Characteristics of the network (Table 3)."""
    rows = [
        (plain(feature), plain(str(value))) for feature, value in frame[["feature", "value"]].itertuples(index=False)
    ]
    caption = plain("Characteristics of the convolutional neural network.")
    return Table("Table 3", "tab:table03", caption, "ll", (plain("Feature"), plain("Value")), [(None, rows)])


def metric_search(frame: pd.DataFrame) -> Table:
    """Best candidate formulas of each factor of the similarity metric."""
    columns = ["rank", "candidate", "formula", "rms_log_error_best", "best_bandwidth", "rms_log_error_mean"]
    columns += ["abstract_mean_total", "chosen"]
    blocks = []
    for factor in dict.fromkeys(frame["factor"]):
        ranked = frame[frame["factor"] == factor].sort_values("rank", kind="stable")
        listed = ranked[(ranked["rank"] <= _LISTED) | ranked["chosen"]]
        rows = [
            (
                number(rank, 0),
                plain(candidate),
                formula(text),
                number(best, 3),
                Text(f"${bandwidth:.4g}$", f"{bandwidth:.4g}"),
                number(mean, 3),
                number(100 * total, 2),
                plain("yes") if chosen else EMPTY,
            )
            for rank, candidate, text, best, bandwidth, mean, total, chosen in listed[columns].itertuples(index=False)
        ]
        blocks.append((plain(f"{factor[:1].upper()}{factor[1:]} factor"), rows))
    caption = plain(
        f"Search for the formula of metr2ev: the {_LISTED} best candidates of each factor by the rms log error with "
        "which they explain the published Table 7; best, with the bandwidth of the random trajectory where it is "
        "reached, and mean over all bandwidths. Last, the mean total (%) of the published parameters on Eq. 10, with "
        "the other factor as chosen; the abstract says 97.38."
    )
    names = ("Rank", "Candidate", "Formula", "Best", "at (rad/s)", "Mean", "On Eq. 10", "Chosen")
    header = tuple(plain(name) for name in names)
    return Table("Metric search", "tab:metric_search", caption, "rllrrrrl", header, blocks)
