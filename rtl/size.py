"""Size of the design on the paper's FPGA, as Yosys maps it to Cyclone IV E, with the published figures next to it.

Yosys maps to look-up tables (LUT) and flip-flops separately. A logic element has one of each, so between max(LUT, FF)
and LUT + FF elements are needed. There is no open placer for this family: nothing here is timed. The design has no
multiplier: products are sums, a bit a clock.
"""

import csv
import json
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from amaranth.back import rtlil
from amaranth.lib.wiring import Component

from rtl.aq_time import AqTime
from rtl.aq_uart import AqUart
from rtl.board import Board
from rtl.compiled import yosys
from rtl.decoder import Decoder
from rtl.fp_ops import FpOps
from rtl.h_bridge import HBridge
from rtl.pd import PD
from rtl.pwm_gen import PwmGen
from rtl.ram import RamFpga
from rtl.read_ram import ReadRam
from rtl.uart import Receiver
from rtl.write_ram import WriteRam

#: Logic elements and M9K blocks of the EP4CE22F17C6.
DEVICE_ELEMENTS, DEVICE_BLOCKS = 22_320, 66
#: Section III of the paper; the memory is published as a share.
PUBLISHED_ELEMENTS, PUBLISHED_MEMORY = 6_683, 0.87
#: The blocks as the board has them at 100 MHz; of Decoder, PWM gen and H bridge it has two.
BLOCKS = {
    "Write Ram": WriteRam(),
    "Ram-FPGA": RamFpga(),
    "Read Ram": ReadRam(),
    "Aq time": AqTime(250_000),
    "Decoder": Decoder(),
    "Fp ops": FpOps(),
    "PD": PD(100e6),
    "PWM gen": PwmGen(),
    "H bridge": HBridge(100, 500),
    "Aq uart": AqUart(868),
    "receiver": Receiver(868),
    "board": Board(),
}


@dataclass(frozen=True)
class Size:
    """Cells of one design."""

    lut: int
    flip_flops: int
    multipliers: int
    memory_blocks: int
    memory_bits: int  # that the design uses

    @property
    def logic_elements(self) -> tuple[int, int]:
        """Least and most logic elements."""
        return max(self.lut, self.flip_flops), self.lut + self.flip_flops


def measure(design: Component) -> Size:
    """Synthesise a design and count its cells."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "design.il").write_text(rtlil.convert(design, name="top"), encoding="utf-8")
        # Yosys' mapping refuses memory with initial content; the design needs none, because it erases its memory.
        steps = (
            "read_rtlil design.il",
            "hierarchy -top top",
            "flatten",
            "delete t:$meminit*",
            "memory_collect",
            "tee -q -o bits.json stat -json",
            "synth_intel -family cycloneive -top top",
            "tee -q -o cells.json stat -json",
        )
        yosys("-q", "-p", "; ".join(steps), folder=folder)
        bits, cells = (json.loads((folder / f"{name}.json").read_text())["design"] for name in ("bits", "cells"))
    of = cells["num_cells_by_type"]
    return Size(
        lut=of.get("cycloneive_lcell_comb", 0),
        flip_flops=of.get("dffeas", 0),
        multipliers=sum(n for name, n in of.items() if "MUL" in name or "mult" in name),
        memory_blocks=of.get("altsyncram", 0),
        memory_bits=bits["num_memory_bits"],
    )


def write_table(path: Path) -> None:
    """Write a row for each block, for the board, and for what was published."""
    with path.open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(("block", "lut", "flip_flops", "elements_least", "elements_most", "m9k_blocks", "memory_bits"))
        for name, block in BLOCKS.items():
            size = measure(block)
            least, most = size.logic_elements
            rows.writerow((name, size.lut, size.flip_flops, least, most, size.memory_blocks, size.memory_bits))


if __name__ == "__main__":
    write_table(Path(sys.argv[1]))
