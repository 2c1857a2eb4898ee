"""The small blocks, each in Amaranth's simulator."""

import csv
import re
from pathlib import Path

import numpy as np
import pytest
from amaranth.hdl import Module
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from repro.board.frames import encode
from repro.errors import InputError
from rtl.aq_time import AqTime
from rtl.aq_uart import AqUart
from rtl.de0_nano import write_project
from rtl.decoder import Decoder
from rtl.h_bridge import HBridge
from rtl.pwm_gen import PwmGen
from rtl.read_ram import ReadRam
from rtl.size import sizes
from rtl.tests.bench import simulate
from rtl.uart import Receiver, Transmitter

GRAY = ((0, 0), (1, 0), (1, 1), (0, 1))


def test_decoder_follows_a_random_walk_at_an_edge_a_clock():
    steps = np.random.default_rng(1).choice([-1, 0, 1], 600, p=[0.3, 0.1, 0.6])
    block = Decoder()

    async def testbench(ctx):
        await ctx.tick().repeat(5)
        count = 0
        for step in steps.tolist():
            count += step
            a, b = GRAY[count % 4]
            ctx.set(block.a, a)
            ctx.set(block.b, b)
            await ctx.tick()
        await ctx.tick().repeat(3)
        assert ctx.get(block.position) == count == steps.sum()

    simulate(block, testbench)


@pytest.mark.parametrize("level", range(4))
def test_decoder_starts_at_zero_whatever_the_pins_show(level):
    block = Decoder()

    async def testbench(ctx):
        a, b = GRAY[level]
        ctx.set(block.a, a)
        ctx.set(block.b, b)
        await ctx.tick().repeat(10)
        assert ctx.get(block.position) == 0

    simulate(block, testbench)


def test_sampling_instants_are_a_period_apart():
    block = AqTime(25)

    async def testbench(ctx):
        ctx.set(block.start, 1)
        await ctx.tick()
        ctx.set(block.start, 0)
        ctx.set(block.running, 1)
        instants = []
        for clock in range(101):
            if ctx.get(block.sample):
                instants.append(clock)
            await ctx.tick()
        assert instants == [0, 25, 50, 75, 100]

    simulate(block, testbench)


@pytest.mark.parametrize("tau", [0, 1, -1, 511, -700, 1022, 1023, -1023])
def test_pwm_is_high_in_tau_of_1023_slots(tau):
    block = PwmGen()
    clocks_a_slot = 2

    async def testbench(ctx):
        ctx.set(block.tau, tau)
        ctx.set(block.phase_step, round(2**32 / (1023 * clocks_a_slot)))
        await ctx.tick().repeat(4)
        forward = backward = 0
        for _ in range(1023 * clocks_a_slot):
            forward += ctx.get(block.forward)
            backward += ctx.get(block.backward)
            assert not ctx.get(block.forward) & ctx.get(block.backward)
            await ctx.tick()
        assert forward == pytest.approx(max(tau, 0) * clocks_a_slot, abs=1)
        assert backward == pytest.approx(max(-tau, 0) * clocks_a_slot, abs=1)

    simulate(block, testbench)


def test_bridge_pauses_between_directions_and_has_a_clock():
    block = HBridge(pause=5, half_period=4)

    async def testbench(ctx):
        ctx.set(block.forward, 1)
        await ctx.tick().repeat(3)
        assert (ctx.get(block.in1), ctx.get(block.in2)) == (1, 0)
        ctx.set(block.forward, 0)
        ctx.set(block.backward, 1)
        seen = []
        for _ in range(12):
            await ctx.tick()
            seen.append((ctx.get(block.in1), ctx.get(block.in2)))
        assert seen == [(0, 0)] * 5 + [(0, 1)] * 7
        levels = []
        for _ in range(16):
            levels.append(ctx.get(block.clock))
            await ctx.tick()
        assert np.abs(np.diff(levels)).sum() in (3, 4) and sum(levels) == 8

    simulate(block, testbench)


class Line(wiring.Component):
    """A transmitter and a receiver whose clocks differ by their divisors."""

    def __init__(self, sent, read):
        self.transmitter, self.receiver = Transmitter(sent), Receiver(read)
        super().__init__({"data": In(8), "valid": In(1), "ready": Out(1)})

    def elaborate(self, platform):
        m = Module()
        m.submodules += [self.transmitter, self.receiver]
        m.d.comb += [
            self.receiver.rx.eq(self.transmitter.tx),
            self.transmitter.data.eq(self.data),
            self.transmitter.valid.eq(self.valid),
            self.ready.eq(self.transmitter.ready),
        ]
        return m


@pytest.mark.parametrize(("sent", "read"), [(8, 8), (50, 52), (52, 50)])
def test_line_loses_no_byte_at_full_rate_with_clocks_4_percent_apart(sent, read):
    block = Line(sent, read)
    data = [0x00, 0xFF, 0x55, 0xAA, *np.random.default_rng(1).integers(0, 256, 3).tolist()]

    async def testbench(ctx):
        received = []
        waiting = list(data)
        ctx.set(block.valid, 1)
        for _ in range(10 * max(sent, read) * (len(data) + 1)):
            ctx.set(block.data, waiting[0] if waiting else 0)
            ctx.set(block.valid, bool(waiting))
            taken = waiting and ctx.get(block.ready)
            if ctx.get(block.receiver.valid):
                received.append(ctx.get(block.receiver.data))
            ctx.set(block.receiver.ready, ctx.get(block.receiver.valid))
            await ctx.tick()
            if taken:
                waiting.pop(0)
        assert received == data

    simulate(block, testbench)


def test_receiver_drops_a_byte_without_stop_bit_and_a_short_disturbance():
    block = Receiver(8)

    async def testbench(ctx):
        for level, clocks in ((0, 3), (1, 200), (0, 80), (1, 200)):
            ctx.set(block.rx, level)
            for _ in range(clocks):
                await ctx.tick()
                assert not ctx.get(block.valid)

    simulate(block, testbench)


def test_frames_are_those_of_the_protocol():
    block = AqUart(4)
    position, tau = [[165, -32768], [-2, 32767]], [[5, 1023], [-1023, 0]]

    async def testbench(ctx):
        received = bytearray()
        for k in range(2):
            for joint in range(2):
                ctx.set(block.position[joint], position[joint][k])
                ctx.set(block.tau[joint], tau[joint][k])
            ctx.set(block.start, 1)
            await ctx.tick()
            ctx.set(block.start, 0)
            for _ in range(8):
                while ctx.get(block.tx):
                    await ctx.tick()
                bits = 0
                await ctx.tick().repeat(5)  # the middle of the first data bit
                for i in range(8):
                    bits |= ctx.get(block.tx) << i
                    await ctx.tick().repeat(4)
                assert ctx.get(block.tx)
                received.append(bits)
        assert bytes(received) == encode(position, tau)

    simulate(block, testbench)


def test_a_motion_reads_each_sample_once_and_then_ends():
    block = ReadRam()

    async def testbench(ctx):
        ctx.set(block.samples, 3)
        ctx.set(block.bst, 1)
        await ctx.tick()
        ctx.set(block.bst, 0)
        ctx.set(block.samples, 7)  # of a message that comes while the arm moves
        read, finished = [], 0
        for clock in range(60):
            ctx.set(block.sample, clock % 10 == 0)
            finished += ctx.get(block.finished)
            if ctx.get(block.start):
                read.append((ctx.get(block.read_address), ctx.get(block.first)))
            await ctx.tick()
        assert (read, finished, ctx.get(block.running)) == ([(0, 1), (1, 0), (2, 0)], 1, 0)

    simulate(block, testbench)


def test_project_places_every_pin_and_makes_the_clock(tmp_path):
    write_project(tmp_path, 50_000_000)
    pins = re.findall(r"set_location_assignment .* PIN_(\w+)", (tmp_path / "board.qsf").read_text())
    assert len(pins) == len(set(pins)) == 1 + 2 + 8 + 1 + 1
    verilog = (tmp_path / "board.v").read_text()
    assert re.search(r"clk0_multiply_by\(32'd5\)", verilog) and re.search(r"clk0_divide_by\(32'd5\)", verilog)
    assert "derive_pll_clocks" in (tmp_path / "board.sdc").read_text()
    with pytest.raises(InputError, match="CLOCK_HZ: found 48000000, expected a positive multiple"):
        write_project(tmp_path, 48_000_000)


def test_synthesis_gives_the_kept_numbers():
    kept = csv.reader((Path(__file__).parents[2] / "data/board/size.csv").read_text(encoding="utf-8").splitlines())
    made = sizes("Decoder", "board", "symfpu multiply, multipliers")
    assert {tuple(map(str, row)) for row in made} <= {tuple(row) for row in kept}
