"""Our side of what follows from other numbers: of the paper, of the configuration, of the arm of the appendix."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from repro.fpga.frames import COUNTS_PER_TURN, PWM_LIMIT, RADIANS_PER_COUNT, TORQUE_BITS
from repro.paper.checks.hardware import DEVICE_MEMORY_BITS, FLOAT_BITS
from repro.paper.checks.proof import bounds
from repro.paper.claims import Ours
from repro.paper.ledger.results import Results
from repro.paper.published import Published
from repro.signals.metric import metr2ev
from repro.signals.programs import MEMORY_SAMPLES

#: What computes these numbers.
TARGET = "claims"

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

    def made(value: float, note: str) -> Ours:
        return Ours(float(value), TARGET, note=note)

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
            "the device); gains and buffers may make up the rest",
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
