"""Read Ram (Fig. 2): the desired position of each sampling instant, from the first to the last sample, on bus tryd."""

from amaranth.hdl import Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out


class ReadRam(wiring.Component):
    """Runs a motion of `samples` samples after `bst` until its end or `stop`.

    The motion ends at the sampling instant after its last sample, so the last torque lasts as long as the others.
    """

    def __init__(self) -> None:
        super().__init__(
            {
                "bst": In(1),
                "stop": In(1),
                "samples": In(14),
                "sample": In(1),  # of Aq time
                "read_address": Out(13),
                "read_data": In(64),
                "tryd": Out(32).array(2),
                "first": Out(1),
                "start": Out(1),  # tryd and first are those of a new sample
                "running": Out(1),
                "last": Out(1),  # the last sample has been read
                "finished": Out(1),
            }
        )

    def elaborate(self, platform: object) -> Module:
        """Build the counter of samples."""
        m = Module()
        index, samples, delayed = Signal(14), Signal(14), Signal()
        m.d.comb += [
            self.read_address.eq(index),
            self.tryd[0].eq(self.read_data[32:]),
            self.tryd[1].eq(self.read_data[:32]),
            self.last.eq(self.running & (index == samples)),
            self.finished.eq(self.running & self.sample & self.last),
        ]
        # Two clocks from the start to the first word: one for the index, one for the memory.
        m.d.sync += [delayed.eq(self.running & self.sample & ~self.last), self.start.eq(delayed)]
        with m.If(delayed):
            m.d.sync += self.first.eq(index == 0)
        with m.If(self.start):
            m.d.sync += index.eq(index + 1)
        with m.If(self.stop | self.finished):
            m.d.sync += self.running.eq(0)
        with m.Elif(self.bst):
            m.d.sync += [self.running.eq(1), index.eq(0), samples.eq(self.samples)]
        return m
