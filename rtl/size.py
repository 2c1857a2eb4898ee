"""Size of the design on the paper's FPGA: logic cells and memory blocks as Yosys maps them to Cyclone IV E.

Yosys maps to look-up tables (LUT) and flip-flops apart, and a logic element has one of each: between max(LUT, FF) and
LUT + FF elements are needed. There is no open placer for this family, so nothing here is timed.
"""

import json
import tempfile
from dataclasses import dataclass
from pathlib import Path

from amaranth.back import rtlil
from amaranth.lib.wiring import Component

from rtl.board import Board
from rtl.compiled import yosys

#: Memory of the EP4CE22F17C6: M9K blocks and their bits, and its logic elements.
DEVICE_BLOCKS, DEVICE_BITS, DEVICE_ELEMENTS = 66, 608_256, 22_320


@dataclass(frozen=True)
class Size:
    """What one design takes."""

    lut: int
    flip_flops: int
    multipliers: int  # 9 x 9 bits, as the device has them
    memory_blocks: int

    @property
    def logic_elements(self) -> tuple[int, int]:
        """Least and most logic elements."""
        return max(self.lut, self.flip_flops), self.lut + self.flip_flops


def measure(design: Component) -> Size:
    """Synthesise a design and count its cells."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "design.il").write_text(rtlil.convert(design, name="top"), encoding="utf-8")
        script = "read_rtlil design.il; synth_intel -family cycloneive -top top; tee -q -o stat.json stat -json"
        yosys("-q", "-p", script, folder=folder)
        cells = json.loads((folder / "stat.json").read_text(encoding="utf-8"))["design"]["num_cells_by_type"]
    of = {name.lstrip("\\"): count for name, count in cells.items()}
    return Size(
        lut=sum(n for name, n in of.items() if name.endswith("lcell_comb")),
        flip_flops=of.get("dffeas", 0),
        multipliers=of.get("MUL9", 0) + 2 * of.get("MUL18", 0),
        memory_blocks=sum(n for name, n in of.items() if "ram_block" in name or "altsyncram" in name),
    )


if __name__ == "__main__":
    print(measure(Board()))
