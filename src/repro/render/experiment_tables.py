"""Tables of the simulated experiment: control and parameters (Tables 8, 9), stability, and the verdict."""

import pandas as pd

from repro.errors import InputError
from repro.render.markup import EMPTY, Table, Text, formula, number, plain, scientific, unit
from repro.render.result_tables import heading_of, methods_of, one_row
from repro.signals.programs import SPAN, VALIDATION


def with_unit(name: Text, si: str) -> Text:
    """Name of a column with its unit in brackets."""
    return name + Text("~(", " (") + unit(si) + plain(")")


def control(frame: pd.DataFrame) -> Table:
    """Constants of the embedded system and how well the position follows (Table 8)."""
    rows = []
    for joint in (1, 2):
        row = one_row(frame, {"joint": joint})
        spread = 100.0 * float(row["total_sd"]) if row["seeds"] > 1 else None
        cells = [formula(f"q{joint}"), number(100.0 * float(row["total"]), 2, spread)]
        cells += [number(float(row["kp"]), 4), number(float(row["kv"]), 4)]
        rows.append([*cells, number(float(row["pwm_khz"]), 0), scientific(float(row["c_f"]), 0)])
    gain = Text("$K_{p}$", "Kp"), Text("$K_{v}$", "Kv")
    header = (
        plain("Joint"),
        plain("metr2ev (%)"),
        with_unit(gain[0], "N m/rad"),
        with_unit(gain[1], "N m/rad"),
        Text(r"$f_{\mathrm{PWM}}$~(kHz)", "f PWM (kHz)"),
        with_unit(Text("$c_{f}$", "c_f"), "s^2"),
    )
    caption = plain(
        "Constants of the simulated board and similarity of the desired and the simulated position on the "
        "identification trajectory. Kv is for the change of position over one sample."
    )
    return Table("Table 8", "tab:table08", caption, "lrrrrr", header, [(None, rows)])


#: Methods of Table 9 that stand side by side.
SIDE_BY_SIDE = ("algorithm1", "algorithm1+refinement", "least-squares")


def parameters(frame: pd.DataFrame) -> Table:
    """Parameters of the simulated arm as identified by each method (Table 9)."""
    methods = [method for method in methods_of(frame) if method in SIDE_BY_SIDE]
    left_out = len(methods_of(frame)) - len(methods)
    repeated = bool((frame["estimate_sd"] > 0).any())
    rows = []
    for name, si in dict(zip(frame["parameter"], frame["unit"], strict=True)).items():
        found = [one_row(frame, {"method": method, "parameter": name}) for method in methods]
        cells = [with_unit(formula(name), si), number(float(found[0]["true"]), 4)]
        cells += [number(float(row["estimate"]), 4, float(row["estimate_sd"]) if repeated else None) for row in found]
        rows.append(cells)
    spread = ", ± the standard deviation over the seeds" if repeated else ""
    rest = f" {left_out} further methods are in the CSV." if left_out else ""
    caption = plain(f"True and identified parameters of the simulated arm: median seed{spread}.{rest}")
    header = [plain("Parameter"), plain("True"), *(heading_of(method) for method in methods)]
    return Table("Table 9", "tab:table09", caption, "lr" + "r" * len(methods), header, [(None, rows)])


def stability(frame: pd.DataFrame) -> Table:
    """Conditions for stability of the appendix with the parameters of each method."""
    blocks = []
    for method in methods_of(frame):
        chosen = frame.loc[frame["method"] == method, ["quantity", "symbol", "value", "bound", "holds"]]
        rows = [
            (
                plain(quantity),
                formula(symbol),
                scientific(value, 4),
                scientific(bound, 4),
                plain("yes" if holds else "no"),
            )
            for quantity, symbol, value, bound, holds in chosen.itertuples(index=False)
        ]
        blocks.append((heading_of(method), rows))
    caption = plain(
        "Conditions for input-to-state stability (appendix) with the parameters identified on the simulated arm; a "
        "condition holds if its value exceeds its bound."
    )
    header = tuple(plain(name) for name in ("Condition", "Symbol", "Value", "Bound", "Holds"))
    return Table("Stability", "tab:stability", caption, "llrrl", header, blocks)


def verdict(frame: pd.DataFrame) -> Table:
    """Each method against each of the field's, over many specimens of several arms.

    Columns ``motion, method, opponent, joint, duration, arms, runs, wins, win_share, difference_median,
    difference_low, difference_high``; shares and differences as fractions of 1. A block for each opponent, a row for
    each method and duration: of its comparisons, one for each motion of T1 to T4 and joint, in how many the whole
    interval of the difference lies on either side of 0.
    """
    blocks = []
    for opponent in dict.fromkeys(frame["opponent"]):
        rows = []
        for method in methods_of(frame):
            for duration in sorted(set(frame["duration"])):
                key = {"method": method, "opponent": opponent, "duration": duration}
                rows.append(_tally_row(method, duration, validation_rows(frame, key)))
        blocks.append((plain("Against:") + Text(" ", " ") + heading_of(opponent), rows))
    arms, runs = int(frame["arms"].max()), int(frame["runs"].max())
    caption = plain(
        f"Algorithm 1 and the field's methods on {SPAN}, {runs} specimens of {arms} simulated arms. A comparison is "
        "one motion and joint: a method is better where the whole 95 % interval of the median difference of the totals "
        "lies above 0, worse where it lies below; arms are resampled first, then specimens. The last two columns are "
        "the share of runs won and the median over the comparisons of the difference, in points of a percent. Every "
        "comparison is in the CSV."
    )
    names = ("Method", "Identified on", "Better", "Worse", "Open", "Runs won (%)", "Difference (points)")
    return Table("Verdict", "tab:verdict", caption, "lrrrrrr", tuple(plain(name) for name in names), blocks)


def validation_rows(table: pd.DataFrame, key: dict[str, object]) -> pd.DataFrame:
    """Comparisons on T1 to T4 with these values."""
    rows = table[(table[list(key)] == pd.Series(key)).all(axis=1) & (table["motion"] != "ID")]
    expected = 2 * len(VALIDATION)
    if len(rows) != expected or rows.duplicated(["motion", "joint"]).any():
        place = ", ".join(f"{name} {value}" for name, value in key.items())
        raise InputError.at(place, f"{len(rows)} rows on {SPAN}", f"{expected}: each motion and joint once")
    return rows


def _tally_row(method: str, duration: float, rows: pd.DataFrame) -> list[Text]:
    better, worse = int((rows["difference_low"] > 0).sum()), int((rows["difference_high"] < 0).sum())
    return [
        heading_of(method),
        plain(f"{duration:.4g} s"),
        *(number(float(count), 0) for count in (better, worse, len(rows) - better - worse)),
        number(100.0 * float(rows["wins"].sum() / rows["runs"].sum()), 0),
        number(100.0 * float(rows["difference_median"].median()), 2),
    ]


def both_metrics(frame: pd.DataFrame) -> Table:
    """Headline rows under both time factors, two rows for each method.

    Columns as `repro.pipeline.both_metrics.COLUMNS`.
    """
    words = {"mean-square": "mean square", "energy": "energy ratio"}
    values = ("numeric_id", "numeric_validation", "id1", "id2", "validation", "frequency_id", "frequency_validation")
    blocks = []
    for method in methods_of(frame):
        rows = [
            [
                plain(words[row["formula"]]),
                *(EMPTY if pd.isna(row[name]) else number(100.0 * row[name], 2) for name in values),
            ]
            for row in frame[frame["method"] == method].to_dict("records")
        ]
        blocks.append((heading_of(method), rows))
    caption = plain(
        "The same estimates under both time factors of metr2ev: mean totals of N1 to N4 on the identification and the "
        "validation trajectory, totals of the simulated arm on ID and their mean over T1 to T4, and the mean frequency "
        "factor, which both share; medians over the seeds, %."
    )
    names = ("Time factor", "N1-N4, ID", "N1-N4, validation", "ID, joint 1", "ID, joint 2", "T1 to T4")
    header = [plain(name) for name in (*names, "Freq., ID", "Freq., T1 to T4")]
    return Table("Both metrics", "tab:both_metrics", caption, "lrrrrrrr", header, blocks)
