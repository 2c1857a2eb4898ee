"""Our side of all published numbers: what each is compared with, what we assert, what the audit found."""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd

from repro.comparison.classes import LEDGER
from repro.fpga.frames import COUNTS_PER_TURN, PWM_LIMIT, RADIANS_PER_COUNT, TORQUE_BITS
from repro.paper.audit import findings
from repro.paper.checks.finding import CONTRADICTS, NOT_POSSIBLE, Finding
from repro.paper.checks.hardware import DEVICE_MEMORY_BITS, FLOAT_BITS
from repro.paper.checks.proof import bounds
from repro.paper.claims import LEFT_OUT, REPRODUCED, SETTING, Basis, Ours, ledger
from repro.paper.ledger.choices import choices
from repro.paper.ledger.constants import constants
from repro.paper.ledger.measured import REFINEMENT, measured
from repro.paper.ledger.results import Results
from repro.paper.published import Published
from repro.signals.metric import metr2ev
from repro.signals.programs import MEMORY_SAMPLES

#: Numbers of Appendix A by id: first word of the row of ``stability.csv``, and its column.
APPENDIX = {
    "potential": ("Potential", "value"),
    "energy": ("Energy", "value"),
    "dissipation": ("Dissipation", "value"),
    "coupling": ("Dissipation", "bound"),
    "r1_min": ("Rate", "value"),
    "r2_max": ("Rate", "bound"),
}
_ARM = "arm chosen so that all six numbers come out, Table 9 being lost"


def arithmetic(published: Published, config: Mapping[str, Any], results: Results) -> dict[str, Ours]:
    """Exact and deterministic numbers."""

    def made(value: float, note: str, cause: str = "") -> Ours:
        return Ours(float(value), LEDGER, Basis.ARITHMETIC, cause=cause, note=note)

    signals = config["signals"]
    period, bands = signals["sampling_period_s"], signals["image_samples"]
    n = round(signals["duration_s"] / period)
    half = 2 ** (TORQUE_BITS[0].bit_count() - 1)
    counts = np.iinfo(np.int16)
    used, available = (published[f"section3/logic-{name}"].value for name in ("used", "available"))
    memory = MEMORY_SAMPLES * 2 * FLOAT_BITS
    one = np.sin(np.arange(1.0, 100.0))
    (reach,) = (finding.found for finding in bounds(published) if finding.id == "appendix/sine")
    return {
        "section3/sampling-rate": made(1.0 / period, "1 / 2.5 ms"),
        "section3/position-low": made(counts.min, "-2^15"),
        "section3/position-high": made(counts.max, "2^15 - 1"),
        "section3/position-turns": made(counts.max / COUNTS_PER_TURN, "32767 / 8400"),
        "section3/torque-low": made(-half, "-2^10"),
        "section3/torque-high": made(half - 1, "2^10 - 1"),
        "section3/torque-unit": made(100.0 / PWM_LIMIT, "100 % / 1023"),
        "section3/encoder-step": made(RADIANS_PER_COUNT, "2 pi / (64 x 131.25)"),
        "section3/logic-share": made(100.0 * used / available, f"{used:.0f} / {available:.0f}"),
        "section3/memory-share": made(
            100.0 * memory / DEVICE_MEMORY_BITS,
            f"the trajectory alone, {MEMORY_SAMPLES} x 2 x {FLOAT_BITS} of {DEVICE_MEMORY_BITS} bits (data sheet of "
            "the device)",
            "unlisted memory",
        ),
        "section4a/band-low": made(0.0, "band k = 0"),
        "section4a/band-high": made((bands - 1) / (2.0 * period * n), f"({bands} - 1) / (2 x 2.5 ms x {n})"),
        "section4c/identical": made(100.0 * float(metr2ev(one, one).total), "metr2ev of a signal with itself"),
        "appendix/domain": made(reach / math.pi, f"{reach:.3f} / pi"),
        **{
            f"appendix/{name}": Ours(results.stability(*where), "stability", note=_ARM)
            for name, where in APPENDIX.items()
        },
    }


#: Kinds of number that are asserted wherever we have a counterpart.
ASSERTED_KINDS = (SETTING, "exact", "deterministic")
#: What is asserted of the numeric tests: the listed algorithm and our refinement of it reach the abstract's mean. The
#: central claim about the arm is asserted where it is made, in the sense that it is not reproduced.
ASSERTED = ("abstract/numeric/total", f"abstract/numeric/total{REFINEMENT}")
_HARDWARE = "property of the authors' arm, board or bench"
#: Findings that are about one published number under another name than its id.
_ABOUT = {"appendix/sine": "appendix/domain"}


def counterparts(published: Published, config: Mapping[str, Any], results: Results) -> dict[str, Ours]:
    """Our side of every published number that is the paper's own."""
    found = {**choices(config), **constants(), **arithmetic(published, config, results), **measured(results, config)}
    audited = findings(published)
    contradictions = {about(finding): finding for finding in audited if about(finding)}
    remarks = {number: _told(f) for f in audited if f.verdict == NOT_POSSIBLE for number in f.numbers}
    whole: dict[str, Ours] = {}
    for number in published:
        if number.kind == LEFT_OUT:
            continue
        side = found.pop(number.id, Ours(None, "", note=_HARDWARE))
        finding = contradictions.get(number.id)
        if finding is not None:
            side = replace(side, contradicts=_told(finding), contradiction=_size(finding))
        elif number.id in remarks:
            side = replace(side, note=f"{side.note}; not possible: {remarks[number.id]}")
        adopted = number.kind in ASSERTED_KINDS and side.value is not None and finding is None and not side.unused
        whole[number.id] = replace(side, asserted=REPRODUCED) if adopted else side
    for name in ASSERTED:
        sides = whole if name in whole else found
        sides[name] = replace(sides[name], asserted=REPRODUCED)
    return {**whole, **found}


def about(finding: Finding) -> str:
    """Id of the one published number that a finding proves wrong; empty if it proves none wrong.

    A contradiction between several numbers, of which it does not say which is wrong, paints over none of them; a
    Total that is not the product of its factors is taken for the wrong one of the three.
    """
    if finding.id in _ABOUT:
        return _ABOUT[finding.id]
    name = finding.id.removeprefix("composition/")
    return name if finding.verdict == CONTRADICTS and name in finding.numbers else ""


def _told(finding: Finding) -> str:
    return f"{finding.arithmetic}. {finding.note}".removesuffix(". ").rstrip(".")


def _size(finding: Finding) -> float:
    """By how much the paper contradicts itself; infinite where words do."""
    size = abs(finding.found - finding.printed)
    return size if math.isfinite(size) else math.inf


def compute(published: Published, config: Mapping[str, Any], results: Results) -> pd.DataFrame:
    """The ledger from its sources."""
    return ledger(published, counterparts(published, config, results))
