"""Size of the design on the paper's FPGA, as Yosys maps it to Cyclone IV E.

Yosys maps to look-up tables (LUT) and flip-flops separately. A logic element has one of each, so between max(LUT, FF)
and LUT + FF elements are needed. There is no open placer for this family: nothing here is timed.
"""

import json
import tempfile
from collections.abc import Callable
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

#: The EP4CE22F17C6 by its data sheet.
DEVICE = {"elements": 22_320, "multipliers": 132, "memory_blocks": 66, "memory_bits": 608_256}
#: The blocks as the board has them at 100 MHz; of Decoder, PWM gen and H bridge it has two.
BLOCKS: dict[str, Callable[[], Component]] = {
    "Write Ram": WriteRam,
    "Ram-FPGA": RamFpga,
    "Read Ram": ReadRam,
    "Aq time": lambda: AqTime(250_000),
    "Decoder": Decoder,
    "Fp ops": FpOps,
    "PD": lambda: PD(100e6),
    "PWM gen": PwmGen,
    "H bridge": lambda: HBridge(100, 500),
    "Aq uart": lambda: AqUart(868),
    "receiver": lambda: Receiver(868),
    "board": Board,
}
#: Products as multipliers of 18 x 18 bits, each two of the device's of 9 bits. Yosys knows none of this family.
MULTIPLIERS = (
    "proc; opt; wreduce; read_verilog -lib mult.v",
    "techmap -map +/mul2dsp.v -D DSP_A_MAXWIDTH=18 -D DSP_B_MAXWIDTH=18 -D DSP_NAME=MULT",
)
MULT = "module MULT #(parameter A_SIGNED=0, B_SIGNED=0, A_WIDTH=18, B_WIDTH=18, Y_WIDTH=36) "
MULT += "(input [A_WIDTH-1:0] A, input [B_WIDTH-1:0] B, output [Y_WIDTH-1:0] Y); endmodule"
#: Yosys' own IEEE units of single precision, for comparison.
UNITS = {
    f"symfpu {name}": (f"symfpu -op {op} -eb 8 -sb 24 -rm RNE", "chformal -assert -remove", "rename symfpu top", *more)
    for name, op, more in (("add", "add", ()), ("multiply", "mul", ()), ("multiply, multipliers", "mul", MULTIPLIERS))
}
Row = tuple[str, str, int, int]


def measure(name: str, text: str, *source: str) -> list[Row]:
    """Synthesise a design, ``design.il`` or what Yosys' commands make, and count its cells."""
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        (folder / "design.il").write_text(text, encoding="utf-8")
        (folder / "mult.v").write_text(MULT, encoding="utf-8")
        steps = (*source, "tee -q -o bits.json stat -json", "synth_intel -family cycloneive -top top")
        yosys("-q", "-p", "; ".join((*steps, "tee -q -o cells.json stat -json")), folder=folder)
        bits, cells = (json.loads((folder / f"{kind}.json").read_text()) for kind in ("bits", "cells"))
    of = cells["design"]["num_cells_by_type"]
    lut, flip_flops = of.get("cycloneive_lcell_comb", 0), of.get("dffeas", 0)
    counts = {
        "lut": lut,
        "flip_flops": flip_flops,
        "multipliers": 2 * of.get("MULT", 0),
        "memory_blocks": of.get("altsyncram", 0),
        "memory_bits": bits.get("design", {}).get("num_memory_bits", 0),
    }
    elements = (name, "elements", max(lut, flip_flops), lut + flip_flops)
    return [elements, *((name, quantity, count, count) for quantity, count in counts.items())]


def sizes(*names: str) -> list[Row]:
    """Block, quantity, least and most: of the device, and of these blocks and units or of all."""
    rows = [("device", name, number, number) for name, number in DEVICE.items()]
    # Yosys' mapping refuses memory with initial content; the design needs none, because it erases its memory.
    read = ("read_rtlil design.il", "hierarchy -top top", "flatten", "delete t:$meminit*")
    for name in names or (*BLOCKS, *UNITS):
        text = ""
        if name in BLOCKS:
            block = BLOCKS[name]()
            text = rtlil.convert(block, name="top")
            if isinstance(block, Decoder):
                rows.append((name, "position_bits", len(block.position), len(block.position)))
        rows += measure(name, text, *UNITS.get(name, read))
    return rows
