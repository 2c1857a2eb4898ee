"""Ram-FPGA (Fig. 2): the desired positions, 8192 samples of two single-precision numbers, 64 blocks of M9K memory."""

from amaranth.hdl import Module, unsigned
from amaranth.lib import memory, wiring
from amaranth.lib.wiring import In, Out

SAMPLES = 8192
#: Content of a sample that has not been received: NaN, which no message can write.
ABSENT = 2**64 - 1


class RamFpga(wiring.Component):
    """One port to write and one to read; `read_data` is the word whose address was there one clock before."""

    def __init__(self) -> None:
        super().__init__(
            {
                "write_address": In(13),
                "write_data": In(64),
                "write": In(1),
                "read_address": In(13),
                "read_data": Out(64),
            }
        )

    def elaborate(self, platform: object) -> Module:
        """Build the memory."""
        m = Module()
        m.submodules.memory = ram = memory.Memory(shape=unsigned(64), depth=SAMPLES, init=[])
        write, read = ram.write_port(), ram.read_port()
        m.d.comb += [
            write.addr.eq(self.write_address),
            write.data.eq(self.write_data),
            write.en.eq(self.write),
            read.addr.eq(self.read_address),
            self.read_data.eq(read.data),
        ]
        return m
