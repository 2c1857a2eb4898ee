"""Runs a block in Amaranth's simulator."""

from amaranth.sim import Simulator


def simulate(block, testbench):
    """Run a block with one testbench, ``async def testbench(ctx)``, to its end."""
    simulator = Simulator(block)
    simulator.add_clock(1e-6)
    simulator.add_testbench(testbench)
    simulator.run()
