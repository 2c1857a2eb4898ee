"""The report of `repro identify` as one HTML text that opens anywhere and fetches nothing."""

import base64
import re
import struct
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from urllib.parse import quote

from jinja2 import Environment
from markupsafe import Markup, escape

from repro.exhibits.markup import unit
from repro.logs.diagnostics import Description
from repro.ownarm.figures import drawn_methods
from repro.ownarm.result import Curves, Result
from repro.ownarm.tables import blocks, method_columns, percent, predictions, rounded, significant
from repro.ownarm.text import ALLOWED, detection_limits, friction_line, self_test_rows, self_test_verdict, spread_rows
from repro.report.embed import Picture, environment, policy

#: Screen pixels per picture pixel: drawn at 200 dpi, shown at 1.25 times the printed size.
_SHOWN = 1.25 * 96.0 / 200.0

#: A parameter's name in a text.
_SYMBOL = re.compile(r"\b([Igbk])([123])\b")

_PNG = b"\x89PNG\r\n\x1a\n"

#: Contents of the files next to the page.
FILES = {
    "parameters.json": "everything on this page, for programs",
    "parameters.csv": "the parameters of every method, a row each",
    "runs.csv": "the parameters from each log alone, a row each, with their range",
    "residuals.csv": "measured and rebuilt torque over time",
    "scores.csv": "the errors of every method on every log, a row each",
    "arm.urdf": "two links with these inertias, for ROS and most simulators",
    "arm.xml": "the same links for MuJoCo",
    "no-links.txt": "why there is no URDF or MJCF",
    "methods.bib": "sources of the methods, to cite",
}


def render_page(
    result: Result, curves: Curves, figures: Mapping[str, bytes], files: Sequence[str] = tuple(FILES)
) -> str:
    """Lay out the report, the recommended method before the others."""
    best = [method for method in result.methods if method.method == result.recommended]
    if len(best) != 1:
        raise ValueError(f"result.recommended: must name one of the methods, got {result.recommended!r}.")
    result = replace(result, methods=(best[0], *(method for method in result.methods if method is not best[0])))
    style = _style()
    logs = (*result.fitted_logs, *result.validation_logs)
    return (
        _environment()
        .get_template("page.html")
        .render(
            result=result,
            best=best[0],
            style=style,
            policy=policy(style),
            logs=logs,
            fitted=len(result.fitted_logs),
            detection_limits=detection_limits(result),
            facts=_facts(logs),
            predictions=predictions(best[0]),
            columns=method_columns(result),
            blocks=blocks(result),
            pictures={name: _picture(name, content) for name, content in figures.items()},
            overlays=sum(name.startswith("overlay-") for name in figures),
            drawn=[method.title for key in drawn_methods(result) for method in result.methods if method.method == key],
            lengths=[(float(signals.t[-1] - signals.t[0]), signals.t.size) for signals in curves.signals],
            allowed=ALLOWED,
            files=[(name, quote(name), FILES.get(name, "")) for name in files],
            largest_share=max(1.0, *result.excitation.share),
        )
    )


def _environment() -> Environment:
    jinja = environment(Path(__file__).parent)
    jinja.filters |= {
        "unit": lambda text: unit(text).md,
        "symbols": symbols,
        "sentence": sentence,
        "friction": friction_line,
        "rounded": rounded,
        "percent": percent,
        "significant": significant,
        "rows": self_test_rows,
        "spread": spread_rows,
        "conclusion": self_test_verdict,
    }
    return jinja


def symbols(text: str) -> Markup:
    """Escape a text and lower the digit of every parameter's name in it: I1 becomes I with index 1."""
    return Markup(re.sub(_SYMBOL, r"<i>\1</i><sub>\2</sub>", str(escape(text))))


def sentence(text: str) -> str:
    """Begin a text with a capital, unless a parameter's name comes first, and end it with a full stop."""
    start = text if _SYMBOL.match(text) else text[:1].upper() + text[1:]
    return start if not start or start[-1] in ".!?:" else f"{start}."


def _style() -> Markup:
    """Read the styles of the reproduction's report, then those of this page."""
    package = Path(__file__).parents[1]
    paths = (package / "report" / "report.css", package / "ownarm" / "page.css")
    return Markup("".join(path.read_text(encoding="utf-8") for path in paths))


def _picture(name: str, content: bytes) -> Picture:
    if not content.startswith(_PNG):
        raise ValueError(f"figures: {name} must be a PNG file, got one that starts with {content[:8]!r}.")
    width, height = (round(_SHOWN * pixels) for pixels in struct.unpack(">II", content[16:24]))
    return Picture(f"data:image/png;base64,{base64.b64encode(content).decode()}", width, height)


def _facts(logs: Sequence[Description]) -> list[tuple[str, list[str]]]:
    """Give the name of every fact and its value in each log, empty where a log has none."""
    names = dict.fromkeys(name for log in logs for name, _ in log.facts)
    return [(name, [dict(log.facts).get(name, "") for log in logs]) for name in names]
