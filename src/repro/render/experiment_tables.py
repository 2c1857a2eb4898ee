"""Tables of the simulated experiment: control and parameters (Tables 8, 9), stability, and the verdict."""

import pandas as pd

from repro.exhibits.markup import EMPTY, Table, Text, formula, number, plain, scientific, unit
from repro.render.result_tables import heading_of, methods_of, one_row
from repro.signals.programs import SPAN


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
    """Each method against each of the field's over many simulated arms; columns `COMPARISON_COLUMNS` of the study.

    A block for each opponent and set of arms, a row for each method and duration.
    """
    blocks, durations = [], sorted(set(frame["duration"]))
    for opponent in dict.fromkeys(frame["opponent"]):
        for name in dict.fromkeys(frame["set"]):
            own = frame[(frame["opponent"] == opponent) & (frame["set"] == name)]
            rows = [_pair_row(own, method, d) for method in methods_of(frame) for d in durations]
            arms = Text(" ", " ") + plain(f"({int(own['arms'].max())} arms, {name})")
            blocks.append((plain("Against:") + Text(" ", " ") + heading_of(opponent) + arms, rows))
    pairs = len(frame[["method", "opponent"]].drop_duplicates())
    caption = plain(
        f"Algorithm 1 and the field's methods: the mean total over {SPAN} and both joints, paired over simulated arms. "
        "Hodges-Lehmann difference in points of a percent with the interval of Wilcoxon's signed-rank test, "
        f"simultaneous over {pairs} pairs (95 %, Bonferroni), and the p value adjusted by Holm's method. Equivalent: "
        "the whole interval is within 0.5 points. A loop chatters if three quarters of the power of a "
        "torque on ID are above 25 Hz."
    )
    names = ("Method", "Identified on", "Arms won", "Difference", "Interval", "p (Holm)", "Conclusion")
    return Table("Verdict", "tab:verdict", caption, "lrrrrrl", tuple(plain(name) for name in names), blocks)


def _pair_row(frame: pd.DataFrame, method: str, duration: float) -> list[Text]:
    row = one_row(frame, {"method": method, "duration": duration})
    low, high = 100.0 * float(row["low"]), 100.0 * float(row["high"])
    return [
        heading_of(method),
        plain(f"{duration:.4g} s"),
        number(float(row["wins"]), 0),
        number(100.0 * float(row["difference"]), 2),
        plain(f"{low:.2f} to {high:.2f}"),
        number(float(row["p_holm"]), 3),
        plain(str(row["conclusion"])),
    ]


def both_metrics(frame: pd.DataFrame) -> Table:
    """Headline rows under both time factors, two rows for each method.

    Columns as `repro.pipeline.summary.BOTH_METRICS`.
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
