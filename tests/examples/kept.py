"""Text that was kept: the same words, and numbers within what rounding on another processor moves."""

import difflib
import re
from collections.abc import Iterator
from pathlib import Path

from matplotlib.figure import Figure

NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?: %)?")
#: What marks an element of a page besides its text.
ATTRIBUTE = re.compile(r'(<[a-z]\w*\b[^>]*?)\b(?:class|data-\w+)="([^"]*)"')
#: Relative difference of two numbers; one unit of the last printed digit of a decimal or percent is allowed, too,
#: and an absolute difference.
ALLOWED, TINY = 1e-4, 1e-9


def _near(a: str, b: str) -> bool:
    if a == b or not {".", "%"} & set(b):
        return a == b
    mantissa, _, power = b.removesuffix(" %").partition("e")
    unit = float(f"1e{int(power or 0) - len(mantissa.partition('.')[2])}")
    x, y = (float(number.removesuffix(" %")) for number in (a, b))
    return abs(x - y) <= max(ALLOWED * abs(y), 1.01 * unit, TINY)


def _like(a: str, b: str) -> bool:
    return NUMBER.sub("#", a) == NUMBER.sub("#", b) and all(map(_near, NUMBER.findall(a), NUMBER.findall(b)))


def same(obtained: Path, kept: Path) -> None:
    """Compare two files line by line, as `file_regression` asks for it."""
    now, before = (path.read_text(encoding="utf-8").splitlines() for path in (obtained, kept))
    if len(now) == len(before):  # the kept line, where numbers are near it
        now = [b if _like(a, b) else a for a, b in zip(now, before, strict=True)]
    differ = "\n".join(difflib.unified_diff(before, now, "kept", "found", n=0, lineterm=""))
    assert not differ, differ[:4000]


def flat(value: object, name: str = "") -> list[str]:
    """Every number and text of a JSON document, one a line, with its place."""
    if isinstance(value, dict):
        return [line for key, item in value.items() for line in flat(item, f"{name}.{key}")]
    if isinstance(value, list) and any(isinstance(item, (dict, list, str)) for item in value):
        return [line for k, item in enumerate(value) for line in flat(item, f"{name}.{k}")]
    if isinstance(value, list):
        return [f"{name[1:]} = {', '.join(_number(item) for item in value)}"]
    return [f"{name[1:]} = {_number(value)}"]


def _number(value: object) -> str:
    return f"{value:.5e}" if isinstance(value, float) else str(value)


def blocks(page: str) -> list[str]:
    """The text of an HTML page, a line for each block and row of a table."""
    text = " ".join(re.sub(r"<(style|script)\b.*?</\1>", "", page, flags=re.DOTALL).split())
    text = ATTRIBUTE.sub(r"\2 \1", text)
    text = re.sub(r"</(tr|p|li|h\d|dt|dd|div|caption|summary)>", "\n", text)
    return re.sub(r"<[^>]+>", " ", text).splitlines()


def drawn(figure: Figure) -> Iterator[str]:
    """What the axes of a figure show: words, limits, and some points of each line."""
    for axes in figure.axes:
        limits = ", ".join(f"{end:.3e}" for end in (*axes.get_xlim(), *axes.get_ylim()))
        words = (axes.get_title(), axes.get_xlabel(), axes.get_ylabel(), axes.get_xscale(), axes.get_yscale())
        yield f"axes {' | '.join(words)}: {limits}"
        for line in axes.lines:
            points = line.get_xydata()
            some = ", ".join(f"{x:.3e}" for x in points[:: max(len(points) // 4, 1)].ravel())
            look = (line.get_label(), line.get_linestyle(), line.get_marker(), line.get_color(), line.get_linewidth())
            yield f"line {' '.join(map(str, look))}, {len(points)} points: {some}"
        yield from (f"text {text.get_text()} at {text.get_position()}" for text in axes.texts)
    yield from (f"legend {text.get_text()}" for legend in figure.legends for text in legend.get_texts())
