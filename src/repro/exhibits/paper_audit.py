"""The paper's own numbers: the search for its metric, the size of its board next to ours, and its audit."""

import math
import re
from collections.abc import Hashable, Mapping
from functools import partial
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from repro.config.model import Configuration
from repro.drawing import style
from repro.drawing.markup import Table, Text, digits, formula, grid, layout, number, plain, scientific, unit, words
from repro.exhibits.declare import Inputs, figure, table
from repro.files import read_csv
from repro.paper.audit import findings_table
from repro.paper.finding import CONSISTENT, VERDICTS
from repro.paper.published import load_published

_table, _figure = (partial(kind, category="Metric", inputs=("search",)) for kind in (table, figure))


def _search(inputs: Inputs) -> pd.DataFrame:
    return read_csv(inputs["search"][0], ("factor", "candidate", "rms_log_error_best", "chosen"))


#: Candidates of each factor in the figure and in the table; the chosen one is added if it is not among them.
_DRAWN, _LISTED = 12, 10


def _span(low: Text, high: Text) -> Text:
    """Smallest and largest value."""
    return low if low == high else low + " to " + high


def _significant(value: float) -> Text:
    """A number with three significant digits or more, as a power of ten from 10,000 on."""
    if abs(value) >= 1e4:
        return scientific(value, 1)
    decimals = 2 - math.floor(math.log10(abs(value))) if value else 0
    return number(value, max(0, decimals))


def _chosen(row: Mapping[Hashable, Any]) -> Text:
    return plain("yes" if row["chosen"] else "")


def _listed(frame: pd.DataFrame) -> list[tuple[Text, pd.DataFrame]]:
    """Best candidates of each factor by their rank."""
    listed = frame[(frame["rank"] <= _LISTED) | frame["chosen"]].sort_values("rank", kind="stable")
    return [(plain(f"{f.capitalize()} factor"), listed[listed["factor"] == f]) for f in dict.fromkeys(frame["factor"])]


@_table(
    "Ranking of the formulas of metr2ev",
    layout(
        f"Search for the formula of metr2ev: the {_LISTED} candidates of each factor with the smallest rms log error "
        "against the published Table 7. Without an arm: smallest and largest rank if one of the four arms is left "
        "out. Best: error at the motion that suits the candidate best, with the length and the bandwidth of this "
        "motion, not the chosen one. Mean: mean error of all motions. Eq. 10: mean total (%) of the published "
        "parameters on Eq. 10 with the chosen formula of the other factor; the abstract prints 97.38.",
        ("Rank", "r", digits("rank", 0)),
        ("Without an arm", "l", lambda row: _span(number(row["rank_low"], 0), number(row["rank_high"], 0))),
        ("Candidate", "l", words("candidate")),
        ("Formula", "l", lambda row: formula(row["formula"])),
        ("Best", "r", digits("rms_log_error_best", 3)),
        ("Samples", "r", digits("samples", 0)),
        ("rad/s", "r", lambda row: _significant(row["bandwidth"])),
        ("Mean", "r", digits("rms_log_error_mean", 3)),
        ("Eq. 10", "r", digits("abstract_mean_total", 2, 100.0)),
        ("Chosen", "l", _chosen),
        blocks=_listed,
    ),
)
def metric_search_table(inputs: Inputs, _: Configuration) -> pd.DataFrame:
    """Ranking of candidate formulas of metr2ev by their rms log error against the published Table 7, with the range of
    ranks if one of the four arms is left out.
    """
    return _search(inputs)


@_table(
    "Random motions that explain Table 7",
    layout(
        "Random motions of the search, with the bandwidth of their filter in rad/s and in bands of the DCT-II. The "
        "published c_f is 100 bands if omega is the band number. Torque: smallest and largest mean-square torque in "
        "(N m)^2 of the four arms and two joints, each the median of the repeats. Bounds: how many of the eight cells "
        "are below the largest mean-square torque that the published Table 7 permits. Last, rms log errors against "
        "Table 7 of the mean square, the energy ratio, the chosen frequency formula and both chosen formulas together. "
        "Chosen: the smallest error with the published c_f of 100 bands.",
        ("Samples", "r", digits("samples", 0)),
        ("s", "r", lambda row: _significant(row["duration"])),
        ("rad/s", "r", lambda row: _significant(row["bandwidth"])),
        ("Bands", "r", lambda row: _significant(row["bands"])),
        ("Torque", "l", lambda row: _span(*(_significant(row[f"mean_square_{end}"]) for end in ("low", "high")))),
        ("Bounds", "r", digits("bounds_satisfied", 0)),
        ("Mean square", "r", digits("rms_log_error_mean_square", 3)),
        ("Energy", "r", digits("rms_log_error_energy", 3)),
        ("Frequency", "r", digits("rms_log_error_frequency", 3)),
        ("Both", "r", digits("rms_log_error_pair", 3)),
        ("Chosen", "l", _chosen),
    ),
)
def metric_motions(inputs: Inputs, _: Configuration) -> pd.DataFrame:
    """Random motions of different length and bandwidth: their mean-square torque, the bounds from the published Table 7
    that it satisfies, and the rms log errors of the formulas of metr2ev against that table.
    """
    return read_csv(inputs["motions"][0], ("samples", "bandwidth", "bounds_satisfied", "chosen"))


_CANDIDATE_MARKS: dict[str, dict[str, Any]] = {
    "Candidate": {"marker": "o", "ms": 4.0, "mfc": "white"},
    "Chosen": {"marker": "D", "ms": 5.0, "mfc": style.INK},
}


def draw_candidates(frame: pd.DataFrame) -> Figure:
    """Best candidate formulas of each factor of the similarity metric."""
    ranked = frame.sort_values("rms_log_error", kind="stable")
    shown = ranked[(ranked.groupby("factor").cumcount() < _DRAWN) | ranked["chosen"]]
    factors = list(dict.fromkeys(frame["factor"]))
    height = 0.8 + 0.165 * int(shown["factor"].value_counts().max())
    figure, panels = style.new_panels(style.PAGE, height, 1, len(factors))
    for axes, factor in zip(panels, factors, strict=True):
        rows = shown[shown["factor"] == factor]
        place = np.arange(len(rows))
        axes.hlines(place, 0.0, rows["rms_log_error"], color="0.80", lw=0.6)
        for label, look in _CANDIDATE_MARKS.items():
            here = (rows["chosen"] == (label == "Chosen")).to_numpy()
            axes.plot(rows["rms_log_error"][here], place[here], ls="none", mec=style.INK, mew=0.8, label=label, **look)
        axes.set_yticks(place, labels=rows["candidate"], parse_math=False)
        axes.set(ylim=(len(rows) - 0.5, -0.5), xlim=(0.0, 1.05 * float(rows["rms_log_error"].max())))
        axes.set(title=f"{factor.capitalize()} factor", xlabel="RMS log error (dimensionless)")
        axes.grid(visible=False, axis="y")
    return style.legend_above(figure, panels[0], 2)


@_figure("Candidates for the metric's formula", draw_candidates)
def metric_search_figure(inputs: Inputs, _: Configuration) -> pd.DataFrame:
    """How well candidate formulas of metr2ev explain the Time and Freq. rows of the published Table 7, given the
    published parameters of Tables 4 and 5: an error of 0 would be a perfect explanation. A frequency formula is named
    by its spectrum, normalisation and distance. Chosen are formulas that explain the other printed values, too.
    """
    table = _search(inputs).rename(columns={"rms_log_error_best": "rms_log_error"})
    return table[["factor", "candidate", "rms_log_error", "chosen"]]


_SIZES = ("block", "quantity", "least", "most")
#: Published numbers by their place in the table.
_PUBLISHED = {
    ("published", "elements"): "section3/logic-used",
    ("published (%)", "elements"): "section3/logic-share",
    ("published (%)", "memory_bits"): "section3/memory-share",
}
_SIZE_COLUMNS = (
    ("Block", "l", words("block")),
    ("LUT4", "r", words("lut")),
    ("Flip-flops", "r", words("flip_flops")),
    ("Logic elements", "r", words("elements")),
    ("9-bit multipliers", "r", words("multipliers")),
    ("M9K", "r", words("memory_blocks")),
    ("Memory bits", "r", words("memory_bits")),
)
_WHOLE, _UNITS = ("board", "board (%)", "published", "published (%)", "device"), "symfpu"


def size_layout(frame: pd.DataFrame) -> Table:
    """Size of each block, of the board next to the published one, and of units that share nothing."""
    bounds = zip(frame["least"].round(2), frame["most"].round(2), strict=True)
    texts = frame.assign(text=[" to ".join(dict.fromkeys(f"{each:,.8g}" for each in pair)) for pair in bounds])
    wide = texts.pivot(index="block", columns="quantity", values="text").fillna("\N{EN DASH}")
    wide = wide.loc[frame["block"].unique()].reset_index()
    whole, units = wide["block"].isin(_WHOLE), wide["block"].str.startswith(_UNITS)
    groups = (("Blocks", ~whole & ~units), ("Board", whole), ("Units of Yosys that share nothing", units))
    return grid(board_size.caption, _SIZE_COLUMNS, [(plain(name), wide[chosen]) for name, chosen in groups])


@table("Size of the board in logic", size_layout, category="Method", inputs=("board",))
def board_size(inputs: Inputs, _: Configuration) -> pd.DataFrame:
    """Size of the board in logic, as Yosys maps it to the paper's FPGA without placing it. A logic element has a
    look-up table of four inputs (LUT4) and a flip-flop, so that the number of elements is between the larger number and
    the sum. The board has two of Decoder, PWM gen and H bridge; (%) is the share of the device. The last rows are IEEE
    units that come with Yosys (symfpu), the product once of look-up tables and once with multipliers of the device.
    What the published board shares is not known, so that a similar number of elements is no evidence.
    """
    frame, printed = read_csv(inputs["synthesis"][0], _SIZES), load_published()
    sizes = frame.set_index(["block", "quantity"])
    share = (100.0 * sizes.loc["board"] / sizes.loc["device"]).dropna().reset_index().assign(block="board (%)")
    rows = [(*place, printed[name].value, printed[name].value) for place, name in _PUBLISHED.items()]
    return pd.concat([frame, share[list(_SIZES)], pd.DataFrame(rows, columns=list(_SIZES))], ignore_index=True)


#: Verdicts in the order of their blocks; what agrees comes last.
_ORDER = (*(verdict for verdict in VERDICTS if verdict != CONSISTENT), CONSISTENT)
_RELATIONS = {
    ">=": Text(r"$\geq$", "\N{GREATER-THAN OR EQUAL TO}"),
    "<=": Text(r"$\leq$", "\N{LESS-THAN OR EQUAL TO}"),
    " x ": Text(r" $\times$ ", " \N{MULTIPLICATION SIGN} "),
    "-": Text("$-$", "-"),
    "->": Text(r"$\rightarrow$", "\N{RIGHTWARDS ARROW}"),
}
#: What is set as mathematics within a sentence: products, minus, relations, symbols with indices and powers, powers.
_MATHS = re.compile(
    r"(?P<relation>>=|<=|->|(?<![\w)\]])-(?=[\d( ])|(?<=[\w%)]) x (?=[\w(]))"
    r"|(?P<symbol>\b(?:(?:lc|[mlJIgbkqRS])[1-3](?!\w)|(?:lambda|rho|epsilon|gamma|beta|pi)(?![A-Za-z])"
    r"|[A-Za-z](?=_[A-Za-z0-9]))(?:_[A-Za-z0-9]+)?(?:\^(?:min|max|\d))?)"
    r"|(?P<power>\^-?\d+)"
)


def _prose(text: str) -> Text:
    """A sentence with formulas typed in ASCII, such as ``lambda_R1^min >= 2 x 10^-3``."""
    pieces, start = plain(""), 0
    for token in _MATHS.finditer(text):
        pieces += plain(text[start : token.start()])
        pieces += _RELATIONS[token["relation"]] if token["relation"] else _symbol(token[0])
        start = token.end()
    return pieces + plain(text[start:])


def _symbol(text: str) -> Text:
    """A symbol or power; Markdown has no subscripts of letters and keeps their underscore."""
    symbol = formula(text)
    name, mark, index = text.partition("_")
    return Text(symbol.tex, formula(name).md + plain(mark + index).md) if index[:1].isalpha() else symbol


def _verdict(verdict: str, found: float, printed: float, si: str) -> Text:
    """Verdict, with what the arithmetic gives and what it is held against where they are numbers."""
    numbers = [(name, value) for name, value in (("found", found), ("printed", printed)) if np.isfinite(value)]
    text = plain(verdict)
    if verdict == CONSISTENT or not numbers:
        return text
    for place, (name, value) in enumerate(numbers):
        digits = f"{value:.6g}"
        amount = scientific(value, 5) if "e" in digits else Text(f"${digits}$", digits)
        text = text + ("," if place else ":") + Text(f" {name}~", f" {name} ") + amount
    return text if si in ("", "1") else text + " (" + (formula(si) if "_" in si else unit(si)) + ")"


def audit_layout(frame: pd.DataFrame) -> Table:
    """Findings of the audit of the paper."""
    blank = {"unit": "", "note": ""}
    table = frame.astype(dict.fromkeys(blank, object)).fillna(blank)
    blocks = []
    for verdict in (name for name in _ORDER if (table["verdict"] == name).any()):
        rows = []
        for finding in table[table["verdict"] == verdict].to_dict("records"):
            note = "" if verdict == CONSISTENT or not finding["note"] else f". {finding['note']}"
            texts = (finding["place"], finding["what"] + note, finding["arithmetic"])
            outcome = _verdict(verdict, finding["found"], finding["printed"], finding["unit"])
            rows.append((*map(_prose, texts), outcome))
        blocks.append((plain(f"{verdict} ({len(rows)}): {VERDICTS[verdict]}"), rows))
    caption = plain(
        f"Audit of the paper: its printed numbers and formulas against each other, {len(table)} findings; our results "
        "play no part. Found is what the arithmetic gives, printed what it is held against. The consistent findings "
        "come last, without their values and notes."
    )
    header = [*map(plain, ("Place", "Finding", "Arithmetic", "Verdict"))]
    return Table(caption, "llll", header, blocks, (0.13, 0.36, 0.35, 0.16))


@table("Audit of the paper", audit_layout, category="Claims")
def audit(_: Inputs, __: Configuration) -> pd.DataFrame:
    """Every check of the paper against itself: printed numbers and formulas, each with its arithmetic. Our results play
    no part; where the extraction of the paper's text may be at fault, the note says so.
    """
    return findings_table()
