"""Figures of the report as PNG files in memory."""

import io

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

from repro.exhibits import style
from repro.ownarm import overlays
from repro.ownarm.parameters import parameters
from repro.ownarm.result import Curves, Result

#: Dots per inch: 1432 pixels for the width of a page.
DPI = 200

#: Colours of a picture; lines and their soft edges need no more, and the file is a third as large.
_COLOURS = 96

#: Methods whose curves are drawn: the recommended one and the first of the others.
MOST_METHODS = 3

#: Logs whose curves are drawn, so that the page stays light.
MOST_LOGS = 8


def figures_of(result: Result, curves: Curves) -> dict[str, bytes]:
    """Draw all figures of the report."""
    titles, methods = overlays.ordered_titles(result), drawn_methods(result)
    logs = list(zip((result.log, *result.more_logs, *result.validation_logs), curves.signals, strict=True))[:MOST_LOGS]
    with style.house_style():
        figures = {"parameters": _png(parameters(result))}
        if curves.cutoff is not None:
            figures["cutoff"] = _png(overlays.cutoff(curves.cutoff, result.simulated))
        for place, (log, signals) in enumerate(logs):
            simulated = log.simulated or result.simulated
            figures[f"overlay-{place}"] = _png(overlays.overlay(signals, methods, titles, simulated))
            figures[f"spectra-{place}"] = _png(overlays.spectra(signals, methods[:1], titles, simulated))
    return figures


def drawn_methods(result: Result) -> list[str]:
    """Methods whose curves the overlays show: the recommended one and the first others, `MOST_METHODS` in all."""
    return list(overlays.ordered_titles(result))[:MOST_METHODS]


def _png(figure: Figure) -> bytes:
    """Save with few colours, without date or version."""
    figure.set_dpi(DPI)
    canvas, small = FigureCanvasAgg(figure), io.BytesIO()
    # Once, where saving would draw once more for the layout.
    canvas.draw()  # type: ignore[no-untyped-call]
    image = Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")  # type: ignore[no-untyped-call]
    image.quantize(_COLOURS, Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE).save(small, "PNG")
    return small.getvalue()
