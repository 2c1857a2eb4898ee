"""The paper's own numbers: the search for its metric, and its audit."""

import math
import re
from collections.abc import Hashable, Mapping
from functools import partial
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from repro.exhibits import style
from repro.exhibits.declare import CLAIMS, METRIC, Inputs, figure, table
from repro.exhibits.markup import (
    EMPTY,
    Column,
    Table,
    Text,
    digits,
    formula,
    grid,
    number,
    plain,
    scientific,
    several,
    unit,
    words,
)
from repro.files import read_csv
from repro.paper.audit import audit
from repro.paper.finding import CONSISTENT, VERDICTS
from repro.pipeline.job import Config

_table, _figure = (partial(kind, category=METRIC, inputs=("search",)) for kind in (table, figure))


def _search(inputs: Inputs) -> pd.DataFrame:
    return read_csv(inputs["search"][0], ("factor", "candidate", "rms_log_error_best", "chosen"))


#: Candidates of each factor in the figure; the chosen one is added if it is not among them.
_SHOWN = 12
#: Candidates of each factor in the table; the chosen one is added if it is not among them.
_LISTED = 10


def _span(low: Text, high: Text) -> Text:
    """Smallest and largest value."""
    return low if low == high else low + Text(" to ", " to ") + high


def _significant(value: float) -> Text:
    """A number with three significant digits or more, as a power of ten from 10,000 on."""
    if abs(value) >= 1e4:
        return scientific(value, 1)
    decimals = 2 - math.floor(math.log10(abs(value))) if value else 0
    return number(value, max(0, decimals))


def _chosen(row: Mapping[Hashable, Any]) -> Text:
    return plain("yes") if row["chosen"] else EMPTY


def ranking_layout(frame: pd.DataFrame) -> Table:
    """Best candidate formulas of each factor of the similarity metric."""
    columns: list[Column] = [
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
    ]
    listed = frame[(frame["rank"] <= _LISTED) | frame["chosen"]].sort_values("rank", kind="stable")
    factors = dict.fromkeys(frame["factor"])
    caption = (
        f"Search for the formula of metr2ev: the {_LISTED} candidates of each factor with the smallest rms log error "
        "against the published Table 7. Without an arm: smallest and largest rank if one of the four arms is left "
        "out. Best: error at the motion that suits the candidate best, with the length and the bandwidth of this "
        "motion. Mean: mean error of all motions. Eq. 10: mean total (%) of the published parameters on Eq. 10 with "
        "the chosen formula of the other factor; the abstract prints 97.38."
    )
    return grid(caption, columns, [(plain(f"{f.capitalize()} factor"), listed[listed["factor"] == f]) for f in factors])


@_table("metric_search", "Ranking of the formulas of metr2ev", ranking_layout)
def metric_search_table(inputs: Inputs, _: Config) -> pd.DataFrame:
    """Ranking of candidate formulas of metr2ev by their rms log error against the published Table 7, with the range of
    ranks if one of the four arms is left out.
    """
    return _search(inputs)


def motions_layout(frame: pd.DataFrame) -> Table:
    """Random motions of the search, compared with Table 7."""
    errors = [f"rms_log_error_{name}" for name in ("mean_square", "energy", "frequency", "pair")]
    columns: list[Column] = [
        ("Samples", "r", digits("samples", 0)),
        ("s", "r", lambda row: _significant(row["duration"])),
        ("rad/s", "r", lambda row: _significant(row["bandwidth"])),
        ("Bands", "r", lambda row: _significant(row["bands"])),
        ("Torque", "l", lambda row: _span(*(_significant(row[f"mean_square_{end}"]) for end in ("low", "high")))),
        ("Bounds", "r", digits("bounds_satisfied", 0)),
        *several(("Mean square", "Energy", "Frequency", "Both"), errors, 3),
        ("Chosen", "l", _chosen),
    ]
    caption = (
        "Random motions of the search, with the bandwidth of their filter in rad/s and in bands of the DCT-II. The "
        "published c_f is 100 bands if omega is the band number. Torque: smallest and largest mean-square torque in "
        "(N m)^2 of the four arms and two joints, each the median of the repeats. Bounds: how many of the eight cells "
        "are below the largest mean-square torque that the published Table 7 permits. Last, rms log errors against "
        "Table 7 of the mean square, the energy ratio, the chosen frequency formula and both chosen formulas together."
    )
    return grid(caption, columns, [(None, frame)])


@_table("metric_motions", "Random motions that explain Table 7", motions_layout, target="metric_motions")
def metric_motions(inputs: Inputs, _: Config) -> pd.DataFrame:
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
    factors = list(dict.fromkeys(frame["factor"]))
    shown = []
    for factor in factors:
        ranked = frame[frame["factor"] == factor].sort_values("rms_log_error", kind="stable").reset_index(drop=True)
        shown.append(ranked[(ranked.index < _SHOWN) | ranked["chosen"]])
    figure = style.new_figure(style.PAGE, 0.8 + 0.165 * max(len(rows) for rows in shown))
    panels = figure.subplots(1, len(factors), squeeze=False)[0]
    for axes, factor, rows in zip(panels, factors, shown, strict=True):
        place = np.arange(len(rows))
        axes.hlines(place, 0.0, rows["rms_log_error"], color="0.80", lw=0.6)
        for label, look in _CANDIDATE_MARKS.items():
            here = (rows["chosen"] == (label == "Chosen")).to_numpy()
            axes.plot(rows["rms_log_error"][here], place[here], ls="none", mec=style.INK, mew=0.8, label=label, **look)
        axes.set_title(f"{factor[:1].upper()}{factor[1:]} factor")
        axes.set_yticks(place, labels=rows["candidate"], parse_math=False)
        axes.set_ylim(len(rows) - 0.5, -0.5)
        axes.set_xlim(0.0, 1.05 * float(rows["rms_log_error"].max()))
        axes.grid(visible=False, axis="y")
        axes.set_xlabel("RMS log error (dimensionless)")
    style.legend_above(figure, panels[0], 2)
    return figure


@_figure("metric_search", "Candidates for the metric's formula", draw_candidates)
def metric_search_figure(inputs: Inputs, _: Config) -> pd.DataFrame:
    """How well candidate formulas of metr2ev explain the Time and Freq. rows of the published Table 7, given the
    published parameters of Tables 4 and 5.
    """
    table = _search(inputs).rename(columns={"rms_log_error_best": "rms_log_error"})
    return table[["factor", "candidate", "rms_log_error", "chosen"]]


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
    pieces, start = EMPTY, 0
    for token in _MATHS.finditer(text):
        pieces += _words(text[start : token.start()])
        pieces += _RELATIONS[token["relation"]] if token["relation"] else _symbol(token[0])
        start = token.end()
    return pieces + _words(text[start:])


def _symbol(text: str) -> Text:
    """A symbol or power; Markdown has no subscripts of letters and keeps their underscore."""
    symbol = formula(text)
    name, mark, index = text.partition("_")
    return Text(symbol.tex, formula(name).md + plain(mark + index).md) if index[:1].isalpha() else symbol


def _words(text: str) -> Text:
    """Words between two formulas; the spaces at their ends stay."""
    if not text.strip():
        return Text(" ", " ") if text else EMPTY
    before, after = (Text(" ", " ") if text[end].isspace() else EMPTY for end in (0, -1))
    return before + plain(text) + after


def _verdict(verdict: str, found: float, printed: float, si: str) -> Text:
    """Verdict, with what the arithmetic gives and what it is held against where they are numbers."""
    numbers = [(name, value) for name, value in (("found", found), ("printed", printed)) if np.isfinite(value)]
    text = plain(verdict)
    if verdict == CONSISTENT or not numbers:
        return text
    for place, (name, value) in enumerate(numbers):
        digits = f"{value:.6g}"
        amount = scientific(value, 5) if "e" in digits else Text(f"${digits}$", digits)
        text += plain("," if place else ":") + Text(f" {name}~", f" {name} ") + amount
    if si in ("", "1"):
        return text
    return text + Text(" (", " (") + (formula(si) if "_" in si else unit(si)) + plain(")")


def audit_layout(frame: pd.DataFrame) -> Table:
    """Findings of the audit of the paper."""
    blank = {"unit": "", "note": ""}
    table = frame.astype(dict.fromkeys(blank, object)).fillna(blank)
    blocks = []
    for verdict in _ORDER:
        chosen = table[table["verdict"] == verdict]
        rows = []
        for finding in chosen.to_dict("records"):
            note = "" if verdict == CONSISTENT or not finding["note"] else f". {finding['note']}"
            texts = (finding["place"], finding["what"] + note, finding["arithmetic"])
            outcome = _verdict(verdict, finding["found"], finding["printed"], finding["unit"])
            rows.append((*map(_prose, texts), outcome))
        if rows:
            blocks.append((plain(f"{verdict} ({len(rows)}): {VERDICTS[verdict]}"), rows))
    caption = plain(
        f"Audit of the paper: its printed numbers and formulas against each other, {len(table)} findings; our results "
        "play no part. Found is what the arithmetic gives, printed what it is held against. The consistent findings "
        "come last, without their values and notes."
    )
    header = tuple(plain(name) for name in ("Place", "Finding", "Arithmetic", "Verdict"))
    return Table(caption, "llll", header, blocks, (0.13, 0.36, 0.35, 0.16))


@table("audit", "Audit of the paper", audit_layout, category=CLAIMS, target="audit")
def audit_findings(_: Inputs, __: Config) -> pd.DataFrame:
    """Every check of the paper against itself: printed numbers and formulas, each with its arithmetic. Our results play
    no part; where the extraction of the paper's text may be at fault, the note says so.
    """
    return audit()
