"""Table text in LaTeX and in Markdown at once: symbols, units, formulas, numbers, and the grid around them."""

import re
from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from html import unescape
from typing import Any, Final

import pandas as pd

#: Width of the full page, inches.
PAGE: Final = 7.16

TIMES = "\N{MULTIPLICATION SIGN}"
_DASH = "\N{EN DASH}"
_TEX_WORDS = {"\\": "backslash", "~": "asciitilde", "^": "asciicircum", "<": "less", ">": "greater", "|": "bar"}
_TEX_SPECIAL = str.maketrans(
    {sign: f"\\{sign}" for sign in "{}$&%#_"}
    | {sign: f"\\text{word}{{}}" for sign, word in _TEX_WORDS.items()}
    | {"±": r"$\pm$", _DASH: "--", TIMES: r"$\times$"}
)
_TEX_MATHS = {" ": r"\,", "*": r"\cdot ", "|": r"\vert ", "<": "<", ">": ">", "^": r"\hat{}", "~": r"\sim "}
_MD_SPECIAL = re.compile(r"([\\`*_|<>\[\]])")
_SUBSCRIPTS = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")
SUPERSCRIPTS = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")
_GREEK = {
    name: unescape(f"&{name};")
    for name in ("alpha", "beta", "epsilon", "rho", "gamma", "lambda", "pi", "omega", "psi", "tau")
}

#: A formula is read as numbers, names (letters, then perhaps an index), powers, subscripts, and whatever else.
_FORMULA = re.compile(
    r"(?P<number>\d+(?:\.\d+)?)|(?P<name>[A-Za-z]+)(?P<index>\d*)"
    r"|\^(?P<power>-?[\d.]+|min|max|[A-Za-z]|\([0-9A-Za-z/. +-]*\))|(?<=.)_(?P<below>[0-9A-Za-z]+)|(?P<other>.)"
)
_PRODUCT = re.compile(r"(?<=\d)\s*x\s*(?=\d)")


@dataclass(frozen=True)
class Text:
    """One piece of text in both markups."""

    tex: str
    md: str

    def __add__(self, other: "Text | str") -> "Text":
        """Append a piece, or signs that are the same in both."""
        tex, md = (other, other) if isinstance(other, str) else (other.tex, other.md)
        return Text(self.tex + tex, self.md + md)

    @property
    def bare(self) -> str:
        """As Markdown shows it."""
        return re.sub(r"\\(.)", r"\1", self.md)


def plain(text: str) -> Text:
    """Ordinary text, with every special character escaped; ``100 x 2`` becomes a product."""
    text = _PRODUCT.sub(TIMES, re.sub(r"\s+", " ", text))
    return Text(text.translate(_TEX_SPECIAL), _MD_SPECIAL.sub(r"\\\1", text))


def formula(text: str) -> Text:
    """A formula typed in ASCII, such as ``m2 lc2^2 + J2`` or ``1 - |x-y|^2/|x|^2``.

    A single letter, or letters with an index, is a symbol (``lc1`` is l with index c1); a Greek letter is spelled out;
    any other word is upright; ``_1`` is a subscript. What follows a comma outside brackets is read as a remark.
    """
    brackets = 0
    for place, sign in enumerate(text):
        brackets += (sign == "(") - (sign == ")")
        if sign == "," and brackets == 0:
            return formula(text[:place]) + ", " + plain(text[place + 1 :].strip())
    pieces = [_piece(token) for token in _FORMULA.finditer(text)]
    # LaTeX spaces operators itself
    tex = re.sub(r"\\,([-+=])\\,", r" \1 ", "".join(piece.tex for piece in pieces))
    return Text(f"${tex}$", "".join(piece.md for piece in pieces))


def _piece(token: re.Match[str]) -> Text:
    """What a token of a formula becomes."""
    name, index, power, below, other = token.group("name", "index", "power", "below", "other")
    if power:
        tex = f"\\{power}" if power in ("min", "max") else power
        return Text(f"^{{{tex}}}", power.translate(SUPERSCRIPTS) if re.fullmatch(r"-?\d+", power) else f"^{power}")
    if below:
        return Text(f"_{{{below}}}", below.translate(_SUBSCRIPTS))
    if name:
        return Text(_tex_name(name, index), _GREEK.get(name, name) + index.translate(_SUBSCRIPTS))
    if other:
        escaped = plain(other)
        return Text(_TEX_MATHS.get(other, escaped.tex), "·" if other == "*" else escaped.md or " ")
    return Text(token[0], token[0])


def _tex_name(name: str, index: str) -> str:
    """Symbol or word of a formula in LaTeX maths."""
    if name in _GREEK:
        return f"\\{name}_{{{index}}}" if index else f"\\{name} "
    if index:
        return f"{name[0]}_{{{name[1:]}{index}}}"
    return name if len(name) == 1 else f"\\mathrm{{{name}}}"


def unit(text: str) -> Text:
    """A unit typed in ASCII, such as ``kg m^2/s^2``; ``1`` and ``-`` stand for no unit."""
    if text in ("1", "-"):
        return Text("--", _DASH)
    tex = re.sub(r"\^(-?\d+)", r"^{\1}", plain(text).tex.replace(r"\textasciicircum{}", "^")).replace(" ", r"\,")
    md = re.sub(r"\^(-?\d+)", lambda match: match[1].translate(SUPERSCRIPTS), text).replace(" ", "·")
    return Text(f"$\\mathrm{{{tex}}}$", md)


def with_unit(name: Text, si: str) -> Text:
    """Name of a column with its unit in brackets."""
    return name + Text("~(", " (") + unit(si) + ")"


def number(value: float, decimals: int, spread: float | None = None) -> Text:
    """A number with fixed decimals, and its spread if there is one."""
    digits = f"{value:.{decimals}f}"
    if spread is None:
        return Text(f"${digits}$", digits)
    return Text(f"${digits} \\pm {spread:.{decimals}f}$", f"{digits} ± {spread:.{decimals}f}")


def scientific(value: float, decimals: int) -> Text:
    """A number as a power of ten; 0 stays 0."""
    if value == 0.0:
        return Text("$0$", "0")
    digits, power = f"{value:.{decimals}e}".split("e")
    exponent = str(int(power))
    return Text(f"${digits} \\times 10^{{{exponent}}}$", f"{digits}{TIMES}10{exponent.translate(SUPERSCRIPTS)}")


#: Gap between two columns of a long table, pt; points in an inch.
_COLUMN_GAP, _POINTS = 9.0, 72.27


@dataclass(frozen=True)
class Table:
    """A laid-out table."""

    caption: Text
    alignment: str  # ``l``, ``c`` or ``r`` for each column
    header: Sequence[Text]  # column names
    # rows under a heading that spans all columns; a heading of None is left out
    blocks: Sequence[tuple[Text | None, Sequence[Sequence[Text]]]]
    # width of each column as a share of what the gaps leave of the page, if the text is wrapped and goes on over pages
    shares: Sequence[float] = ()

    def tex(self, label: str) -> str:
        """LaTeX environment of a page-wide table, referred to by `label`; needs the package booktabs."""
        if self.shares:
            return self._long_tex(label)
        lines = [
            r"\begin{table*}[t]",
            r"\centering\footnotesize",
            f"\\caption{{{self.caption.tex}}}",
            f"\\label{{{label}}}",
            r"\smallskip\setlength{\tabcolsep}{4.5pt}",
            f"\\begin{{tabular}}{{@{{}}{self.alignment}@{{}}}}",
            r"\toprule",
            _tex_row(self.header),
        ]
        for heading, rows in self.blocks:
            lines.append(r"\midrule")
            if heading is not None:
                lines += [f"\\multicolumn{{{len(self.alignment)}}}{{l}}{{\\textit{{{heading.tex}}}}} \\\\", r"\midrule"]
            lines += map(_tex_row, rows)
        return "\n".join([*lines, r"\bottomrule", r"\end{tabular}", r"\end{table*}", ""])

    def _long_tex(self, label: str) -> str:
        """LaTeX that goes on over pages, `PAGE` wide; needs array, booktabs and longtable, and text in one column."""
        room = PAGE - (len(self.shares) - 1) * _COLUMN_GAP / _POINTS
        columns = "".join(f">{{\\raggedright\\arraybackslash}}p{{{share * room:.3f}in}}" for share in self.shares)
        head = [r"\toprule", _tex_row(self.header), r"\midrule"]
        lines = [
            r"\begingroup\footnotesize",
            f"\\setlength{{\\tabcolsep}}{{{_COLUMN_GAP / 2:g}pt}}\\setlength{{\\LTcapwidth}}{{{PAGE}in}}",
            f"\\begin{{longtable}}{{@{{}}{columns}@{{}}}}",
            f"\\caption{{{self.caption.tex}}}\\label{{{label}}}\\\\",
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
            lines += [f"{_tex_row(row)}[2pt]" for row in rows]
        return "\n".join([*lines, r"\end{longtable}", r"\endgroup", ""])

    def md(self, title: str) -> str:
        """Markdown table under its title and caption; LaTeX numbers tables itself."""
        rules = {"l": ":---", "c": ":---:", "r": "---:"}
        lines = [f"**{title}.** {self.caption.md}", "", _md_row(self.header)]
        lines.append("| " + " | ".join(rules[side] for side in self.alignment) + " |")
        for heading, rows in self.blocks:
            if heading is not None:
                name = Text("", f"**{heading.md}**")
                lines.append(_md_row([name, *[plain("")] * (len(self.alignment) - 1)]))
            lines += [_md_row(row) for row in rows]
        return "\n".join([*lines, ""])


def _tex_row(cells: Sequence[Text]) -> str:
    return " & ".join(cell.tex for cell in cells) + r" \\"


def _md_row(cells: Sequence[Text]) -> str:
    return "| " + " | ".join(cell.md for cell in cells) + " |"


#: A cell of a row, and a column: its name, its side (``l``, ``c`` or ``r``) and its cells.
Cell = Callable[[Mapping[Hashable, Any]], Text]
Column = tuple[str | Text, str, Cell]
#: Rows under a heading, which is left out if it is None.
Block = tuple[Text | None, pd.DataFrame]


def words(column: str) -> Cell:
    """Cells of ordinary text."""
    return lambda row: plain(str(row[column]))


def digits(column: Hashable, decimals: int, factor: float = 1.0) -> Cell:
    """Cells of numbers times a factor, empty where there is none."""
    return lambda row: plain("") if pd.isna(row[column]) else number(factor * row[column], decimals)


def several(names: Sequence[str], columns: Sequence[str], decimals: int, factor: float = 1.0) -> list[Column]:
    """Columns of numbers in one form."""
    return [(name, "r", digits(column, decimals, factor)) for name, column in zip(names, columns, strict=True)]


def grid(caption: str, columns: Sequence[Column], blocks: Iterable[Block]) -> Table:
    """Lay out every row of the blocks in these columns."""
    names, sides, cells = zip(*columns, strict=True)
    laid_out = [(name, [[cell(row) for cell in cells] for row in rows.to_dict("records")]) for name, rows in blocks]
    header = [name if isinstance(name, Text) else plain(name) for name in names]
    return Table(plain(caption), "".join(sides), header, laid_out)


def layout(
    caption: str,
    *columns: Column,
    blocks: Callable[[pd.DataFrame], Iterable[Block]] = lambda frame: [(None, frame)],
) -> Callable[[pd.DataFrame], Table]:
    """Lay out all rows of a frame in these columns, without headings or in blocks."""
    return lambda frame: grid(caption, columns, blocks(frame))
