"""Table of the audit of the paper: what its numbers and formulas say of each other."""

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from repro.exhibits.markup import EMPTY, PAGE, Table, Text, formula, plain, scientific, tex_row, unit
from repro.paper.finding import CONSISTENT, VERDICTS

#: Between two columns, and of an inch, pt.
_GAP = 9.0
_INCH = 72.27


@dataclass(frozen=True)
class LongTable(Table):
    """A laid-out table whose text is wrapped and that goes on over pages."""

    shares: Sequence[float] = ()  # width of each column as a share of what the gaps between them leave of the page

    def __post_init__(self) -> None:
        """Check that the columns fill the page."""
        if len(self.shares) != len(self.alignment) or abs(sum(self.shares) - 1.0) > 1e-9:
            raise ValueError(f"shares: must be one for each of {len(self.alignment)} columns, of sum 1.")

    def tex(self) -> str:
        """LaTeX of the table, `PAGE` wide; needs array, booktabs and longtable, and text in one column."""
        room = PAGE - (len(self.shares) - 1) * _GAP / _INCH
        columns = "".join(f">{{\\raggedright\\arraybackslash}}p{{{share * room:.3f}in}}" for share in self.shares)
        head = [r"\toprule", tex_row(self.header), r"\midrule"]
        lines = [
            r"\begingroup\footnotesize",
            f"\\setlength{{\\tabcolsep}}{{{_GAP / 2:g}pt}}\\setlength{{\\LTcapwidth}}{{{PAGE}in}}",
            f"\\begin{{longtable}}{{@{{}}{columns}@{{}}}}",
            f"\\caption{{{self.caption.tex}}}\\label{{{self.label}}}\\\\",
            *head,
            r"\endfirsthead",
            *head,
            r"\endhead",
            r"\bottomrule",
            r"\endfoot",
        ]
        for place, (heading, rows) in enumerate(self.blocks):
            if place > 0:
                lines.append(r"\midrule")
            if heading is not None:
                across = f"\\multicolumn{{{len(self.shares)}}}{{@{{}}l@{{}}}}"
                lines.append(f"{across}{{\\textit{{{heading.tex}}}}} \\\\*[2pt]")  # the star keeps it with its rows
            lines += [f"{tex_row(row)}[2pt]" for row in rows]
        return "\n".join([*lines, r"\end{longtable}", r"\endgroup", ""])


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
    made = formula(text)
    name, mark, index = text.partition("_")
    return Text(made.tex, formula(name).md + plain(mark + index).md) if index[:1].isalpha() else made


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


def audit(frame: pd.DataFrame) -> LongTable:
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
    return LongTable("Audit", "tab:audit", caption, "llll", header, blocks, (0.13, 0.36, 0.35, 0.16))
