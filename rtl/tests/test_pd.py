"""PD with the floating-point unit against the controller in Python, at gains, errors and positions of every size."""

import numpy as np
import pytest
from amaranth.hdl import Module
from amaranth.lib import wiring

from repro.board.controller import PDController
from rtl.fp_ops import FpOps
from rtl.pd import PD
from rtl.tests.bench import simulate


class Controller(wiring.Component):
    """PD and Fp ops, connected as on the board."""

    def __init__(self):
        self.pd, self.fp_ops = PD(100e6), FpOps()
        super().__init__({})

    def elaborate(self, platform):
        m = Module()
        m.submodules.pd, m.submodules.fp_ops = pd, fp_ops = self.pd, self.fp_ops
        m.d.comb += [fp_ops.op.eq(pd.fp_op), fp_ops.a.eq(pd.fp_a), fp_ops.b.eq(pd.fp_b), fp_ops.start.eq(pd.fp_start)]
        m.d.comb += [pd.fp_done.eq(fp_ops.done), pd.fp_result.eq(fp_ops.result)]
        return m


def bits(values):
    return np.asarray(values, dtype=np.float32).view(np.uint32).tolist()


@pytest.mark.parametrize(
    ("kp", "kv", "reach"),
    [
        ((67899.67, 11491.39), (130000.0, 9000.0), 0.02),  # of the size of Table 8
        ((500.0, 2.5), (0.0, 1e4), 3.0),
        ((1e-42, 3e38), (1e-45, 1e30), 1.0),  # subnormal and overflowing
    ],
)
def test_torques_are_the_controllers(kp, kv, reach):
    rng = np.random.default_rng(1)
    n = 12
    position = rng.integers(-30000, 30000) + rng.integers(-27, 28, (2, n)).cumsum(axis=1)
    desired = (position * 2 * np.pi / 8400 + rng.uniform(-reach, reach, (2, n))).astype(np.float32)
    reference = PDController(kp, kv)
    expected = [reference(desired[:, k : k + 1], position[:, k : k + 1].astype(np.int32)).ravel() for k in range(n)]
    block = Controller()
    pd = block.pd

    async def testbench(ctx):
        for joint in range(2):
            ctx.set(pd.kp[joint], bits(kp)[joint])
            ctx.set(pd.kv[joint], bits(kv)[joint])
            ctx.set(pd.pwm_hz[joint], bits([1000.0, 20000.0])[joint])
        for k in range(n):
            for joint in range(2):
                ctx.set(pd.position[joint], int(position[joint, k]))
                ctx.set(pd.desired[joint], bits(desired[joint])[k])
            ctx.set(pd.first, k == 0)
            ctx.set(pd.start, 1)
            await ctx.tick()
            ctx.set(pd.start, 0)
            await ctx.tick().until(pd.done)
            assert [ctx.get(tau) for tau in pd.tau] == expected[k].tolist()
        for joint, hz in enumerate((1000.0, 20000.0)):
            assert ctx.get(pd.phase_step[joint]) == pytest.approx(hz * 2**32 / 100e6, abs=1)

    simulate(block, testbench)
