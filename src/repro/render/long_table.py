"""A table of running text, longer than a page."""

from collections.abc import Sequence
from dataclasses import dataclass

from repro.render.markup import PAGE, Table, tex_row

#: Between two columns, and of an inch, pt.
_GAP = 9.0
_INCH = 72.27


@dataclass(frozen=True)
class LongTable(Table):
    """A laid-out table whose text is wrapped and that goes on over pages.

    Attributes
    ----------
    shares : sequence of float
        Width of each column as a share of what the gaps between them leave of the page.
    """

    shares: Sequence[float] = ()

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
