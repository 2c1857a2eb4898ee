"""The board: the blocks of Fig. 2 and the lines between them."""

from amaranth.hdl import Module, Mux, Signal, signed
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from rtl.aq_time import AqTime
from rtl.aq_uart import AqUart
from rtl.decoder import Decoder
from rtl.fp_ops import FpOps
from rtl.h_bridge import HBridge
from rtl.pd import PD
from rtl.pwm_gen import PwmGen
from rtl.ram import RamFpga
from rtl.read_ram import ReadRam
from rtl.uart import Receiver
from rtl.write_ram import WriteRam

#: Pause between the directions of a motor, s, and frequency of the bridge's clock, Hz: ours, the paper has none.
PAUSE, BRIDGE_CLOCK = 1e-6, 100e3


class Board(wiring.Component):
    """Everything between the pins. The outputs below `bridge_clock` report what the board does; no pin needs them."""

    def __init__(self, clock_hz: float = 100e6, baud: float = 115200, sample_hz: float = 400) -> None:
        self._clock_hz = clock_hz
        self._divisor = round(clock_hz / baud)
        self._period = round(clock_hz / sample_hz)
        super().__init__(
            {
                "rx": In(1, init=1),
                "tx": Out(1, init=1),
                "a": In(1).array(2),
                "b": In(1).array(2),
                "in1": Out(1).array(2),
                "in2": Out(1).array(2),
                "bridge_clock": Out(1),
                "running": Out(1),
                "last": Out(1),
                "busy": Out(1),
                "identify": Out(1),
                "refused": Out(1),
                "kind": Out(8),
            }
        )

    def elaborate(self, platform: object) -> Module:
        """Connect the blocks."""
        m = Module()
        m.submodules.receiver = receiver = Receiver(self._divisor)
        m.submodules.write_ram = write_ram = WriteRam()
        m.submodules.ram_fpga = ram = RamFpga()
        m.submodules.read_ram = read_ram = ReadRam()
        m.submodules.aq_time = aq_time = AqTime(self._period)
        m.submodules.fp_ops = fp_ops = FpOps()
        m.submodules.pd = pd = PD(self._clock_hz)
        m.submodules.aq_uart = aq_uart = AqUart(self._divisor)

        m.d.comb += [
            receiver.rx.eq(self.rx),
            write_ram.data.eq(receiver.data),
            write_ram.valid.eq(receiver.valid),
            receiver.ready.eq(write_ram.ready),
            write_ram.running.eq(read_ram.running),
            write_ram.finished.eq(read_ram.finished),
            write_ram.read_data.eq(ram.read_data),
            ram.write_address.eq(write_ram.write_address),
            ram.write_data.eq(write_ram.write_data),
            ram.write.eq(write_ram.write),
            ram.read_address.eq(Mux(write_ram.scanning, write_ram.read_address, read_ram.read_address)),
            read_ram.bst.eq(write_ram.bst),
            read_ram.stop.eq(write_ram.stop),
            read_ram.samples.eq(write_ram.samples),
            read_ram.sample.eq(aq_time.sample),
            read_ram.read_data.eq(ram.read_data),
            aq_time.start.eq(write_ram.bst),
            aq_time.running.eq(read_ram.running),
            pd.start.eq(read_ram.start),
            pd.first.eq(read_ram.first),
            fp_ops.op.eq(pd.fp_op),
            fp_ops.a.eq(pd.fp_a),
            fp_ops.b.eq(pd.fp_b),
            fp_ops.start.eq(pd.fp_start),
            pd.fp_done.eq(fp_ops.done),
            pd.fp_result.eq(fp_ops.result),
            aq_uart.start.eq(pd.done & read_ram.running),
            self.tx.eq(aq_uart.tx),
            self.running.eq(read_ram.running),
            self.last.eq(read_ram.last),
            self.busy.eq(write_ram.busy | receiver.valid),
            self.identify.eq(write_ram.identify),
            self.refused.eq(write_ram.refused),
            self.kind.eq(write_ram.kind),
        ]
        # The torque of a motion reaches the motors from its first result on, and not after its end.
        driving = Signal()
        m.d.sync += driving.eq(read_ram.running & (driving | pd.done))

        for joint in range(2):
            decoder, pwm_gen = Decoder(), PwmGen()
            h_bridge = HBridge(round(PAUSE * self._clock_hz) or 1, round(self._clock_hz / BRIDGE_CLOCK / 2) or 1)
            m.submodules += [decoder, pwm_gen, h_bridge]
            position = Signal(signed(32), name=f"position_{joint + 1}")  # at the sampling instant
            with m.If(aq_time.sample):
                m.d.sync += position.eq(decoder.position)
            tryd, tau = Signal(32, name=f"tryd_{joint + 1}"), pd.tau[joint]
            with m.If(read_ram.start):
                m.d.sync += tryd.eq(read_ram.tryd[joint])
            ctrlv = [write_ram.ctrlv[32 * (5 - i) : 32 * (6 - i)] for i in range(joint, 6, 2)]
            m.d.comb += [
                decoder.a.eq(self.a[joint]),
                decoder.b.eq(self.b[joint]),
                pd.position[joint].eq(position),
                pd.desired[joint].eq(tryd),
                pd.kp[joint].eq(ctrlv[0]),
                pd.kv[joint].eq(ctrlv[1]),
                pd.pwm_hz[joint].eq(ctrlv[2]),
                aq_uart.position[joint].eq(position),
                aq_uart.tau[joint].eq(tau),
                pwm_gen.tau.eq(Mux(driving, tau, 0)),
                pwm_gen.phase_step.eq(pd.phase_step[joint]),
                h_bridge.forward.eq(pwm_gen.forward),
                h_bridge.backward.eq(pwm_gen.backward),
                self.in1[joint].eq(h_bridge.in1),
                self.in2[joint].eq(h_bridge.in2),
            ]
            if joint == 0:
                m.d.comb += self.bridge_clock.eq(h_bridge.clock)
        return m
