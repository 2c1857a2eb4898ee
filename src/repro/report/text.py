"""Captions and Markdown tables as HTML; whatever is not markup is escaped."""

import re
from dataclasses import dataclass

from markupsafe import Markup, escape

from repro.errors import InputError

_INLINE = re.compile(r"``(?P<code>.+?)``|\*\*(?P<strong>.+?)\*\*|\*(?P<em>[^*\s](?:[^*]*[^*\s])?)\*")
_ESCAPED = re.compile(r"\\([\\`*_|<>\[\]])")
_CELL_END = re.compile(r"(?<!\\)\|")
_RULE = re.compile(r":?-+:?")
_CAPTION = re.compile(r"\*\*(?P<title>.+?)\.?\*\*\s*(?P<caption>.*)", re.DOTALL)

#: A row of cells under a heading; the heading is empty where there is none.
Block = tuple[str, list[list[str]]]


def plain(text: str) -> str:
    """Text of a caption without its markup, on one line."""
    return _INLINE.sub(lambda found: next(part for part in found.groups() if part), " ".join(text.split()))


def paragraphs(text: str) -> list[Markup]:
    """Paragraphs of a reStructuredText caption: emphasis, strong text and literals; nothing else is markup."""
    return [_inline(" ".join(part.split())) for part in re.split(r"\n\s*\n", text.strip())]


def _inline(text: str) -> Markup:
    done, at = Markup(), 0
    for found in _INLINE.finditer(text):
        tag = found.lastgroup
        done += escape(text[at : found.start()]) + Markup(f"<{tag}>") + escape(found[str(tag)]) + Markup(f"</{tag}>")
        at = found.end()
    return done + escape(text[at:])


@dataclass(frozen=True)
class MarkdownTable:
    """A table as it is laid out in Markdown.

    Attributes
    ----------
    caption : str
        Caption without the table's name; empty if it has none.
    header : list of str
        Column names.
    sides : list of str
        ``left``, ``right`` or ``centre`` for each column.
    blocks : list of (heading, rows)
        Rows under a heading that spans all columns; the heading may be empty.
    """

    caption: str
    header: list[str]
    sides: list[str]
    blocks: list[Block]


def markdown_table(text: str, place: str) -> MarkdownTable:
    """Read the one table of a Markdown file."""
    lines = [line.strip() for line in text.splitlines()]
    rows = [_cells(line) for line in lines if line.startswith("|")]
    if len(rows) < 3 or not all(_RULE.fullmatch(cell) for cell in rows[1]):
        raise InputError.at(place, "no table", "a Markdown table with a header and a row")
    for number, row in enumerate(rows):
        if len(row) != len(rows[0]):
            raise InputError.at(f"{place}: row {number} of the table", f"{len(row)} cells", f"{len(rows[0])} cells")
    blocks: list[Block] = [("", [])]
    for first, *rest in rows[2:]:
        heading = re.fullmatch(r"\*\*(.+)\*\*", first)
        if heading and rest and not any(rest):
            blocks.append((_unescape(heading[1]), []))
        else:
            blocks[-1][1].append([_unescape(cell) for cell in (first, *rest)])
    words = " ".join(line for line in lines if line and not line.startswith(("|", "#")))
    named = _CAPTION.fullmatch(words)
    return MarkdownTable(
        caption=_unescape(named["caption"] if named else words),
        header=[_unescape(cell) for cell in rows[0]],
        sides=[_side(rule) for rule in rows[1]],
        blocks=[(name, body) for name, body in blocks if name or body],
    )


def _cells(line: str) -> list[str]:
    return [cell.strip() for cell in _CELL_END.split(line)[1:-1]]


def _unescape(text: str) -> str:
    return _ESCAPED.sub(r"\1", text)


def _side(rule: str) -> str:
    if rule.endswith(":"):
        return "centre" if rule.startswith(":") else "right"
    return "left"
