"""The floating-point operations against NumPy's float32: random operands and all pairs of corners."""

import ctypes
from pathlib import Path

import numpy as np
import pytest
from amaranth.hdl import Instance, Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from rtl.compiled import compile_design
from rtl.fp_ops import FpOps, Op

#: Zeros, subnormals, the smallest normal and its neighbours, powers of two, ties, the largest, infinities, NaN.
CORNERS = np.array(
    [
        *(0x00000000, 0x00000001, 0x00000002, 0x00000003, 0x00400000, 0x007FFFFE, 0x007FFFFF, 0x00800000, 0x00800001),
        *(0x00FFFFFF, 0x01000000, 0x01000001, 0x0C000000, 0x1F800000, 0x20000000, 0x33800000, 0x34000000, 0x34000001),
        *(0x3EFFFFFF, 0x3F000000, 0x3F000001, 0x3F7FFFFF, 0x3F800000, 0x3F800001, 0x3FC00000, 0x40200000, 0x4B000000),
        *(0x4B000001, 0x4B7FFFFF, 0x4B800000, 0x4EFFFFFF, 0x4F000000, 0x4F000001, 0x4F800000, 0x5F800000, 0x7E800000),
        *(0x7EFFFFFF, 0x7F000000, 0x7F7FFFFF, 0x7F800000, 0x7F800001, 0x7FC00000, 0x7FFFFFFF),
    ],
    dtype=np.uint32,
)
CORNERS = np.concatenate([CORNERS, CORNERS | np.uint32(1 << 31)])
INTEGERS = np.array([0, 1, 2, 3, 2**24 - 1, 2**24, 2**24 + 1, 2**24 + 2, 2**24 + 3, 2**25 + 2, 2**31 - 1, 2**31, 65535])
FLOAT = {
    Op.ADD: np.add,
    Op.SUB: np.subtract,
    Op.MUL: np.multiply,
}


def compiled(design, before=""):
    """Function that runs a unit over arrays of operands."""
    library = compile_design(design, Path(__file__).with_name("fp_ops.cc"), before=before)
    library.run.restype = ctypes.c_uint64

    def run(op, a, b):
        a, b, result = (np.ascontiguousarray(x, dtype=np.uint32) for x in (a, b, np.zeros(len(a))))
        pointers = [x.ctypes.data_as(ctypes.c_void_p) for x in (a, b, result)]
        library.run(ctypes.c_uint32(op), ctypes.c_uint64(len(a)), *pointers)
        return result

    return run


@pytest.fixture(scope="module")
def unit():
    return compiled(FpOps())


def operands(rng, n=1_000_000):
    """Bits at random, the second operand of half of them close to the first; and all pairs of corners."""
    a, b = rng.integers(0, 2**32, (2, n), dtype=np.uint32)
    near = a + rng.integers(-(1 << 25), 1 << 25, n).astype(np.uint32) ^ rng.integers(0, 2, n).astype(np.uint32) << 31
    b = np.where(rng.random(n) < 0.5, near, b).astype(np.uint32)
    pairs = np.array(np.meshgrid(CORNERS, CORNERS)).reshape(2, -1)
    return np.concatenate([a, pairs[0]]), np.concatenate([b, pairs[1]])


@pytest.mark.parametrize("op", FLOAT)
def test_operation_is_numpys(unit, op):
    a, b = operands(np.random.default_rng(op))
    result = unit(op, a, b)
    with np.errstate(all="ignore"):
        expected = FLOAT[op](a.view(np.float32), b.view(np.float32))
    nan = np.isnan(expected)
    assert np.array_equal(np.isnan(result.view(np.float32)), nan)
    assert np.array_equal(result[~nan], expected.view(np.uint32)[~nan])


def test_integer_to_float_is_numpys(unit):
    rng = np.random.default_rng(1)
    small = rng.integers(-(2**27), 2**27, 500_000)
    integers = np.concatenate([rng.integers(-(2**31), 2**31, 500_000), small, INTEGERS, -INTEGERS]).astype(np.int32)
    result = unit(Op.FROM_INT, integers.view(np.uint32), integers.view(np.uint32))
    assert np.array_equal(result, integers.astype(np.float32).view(np.uint32))


def test_float_to_integer_rounds_and_saturates(unit):
    rng = np.random.default_rng(2)
    halves = (rng.integers(-5000, 5000, 200_000) / 2).astype(np.float32)
    bits = np.concatenate([rng.integers(0, 2**32, 800_000, dtype=np.uint32), halves.view(np.uint32), CORNERS])
    result = unit(Op.TO_INT, bits, bits).view(np.int32)
    with np.errstate(invalid="ignore"):
        wide = bits.view(np.float32).astype(np.float64)
    exact = np.rint(np.nan_to_num(wide, nan=0.0, posinf=2.0**40, neginf=-(2.0**40)))
    assert np.array_equal(result, exact.clip(-(2**31), 2**31 - 1).astype(np.int32))


class Symfpu(wiring.Component):
    """Yosys' generated IEEE unit with the ports of `FpOps`."""

    def __init__(self, width, a, b, output):
        self._ports, self._width = (a, b, output), width
        signature = {"op": In(3), "a": In(width), "b": In(width), "start": In(1), "done": Out(1), "result": Out(width)}
        super().__init__(signature)

    def elaborate(self, platform):
        m = Module()
        a, b, output = self._ports
        result = Signal(self._width)
        inputs = {f"i_{a}": self.a, f"i_{b}": self.b if b != "is_signed" else 1}
        m.submodules.symfpu = Instance("symfpu", **inputs, **{f"o_{output}": result})
        m.d.sync += [self.done.eq(self.start), self.result.eq(result)]
        return m


def commands(pass_):
    return f"{pass_} -rm RNE; chformal -assert -remove symfpu"


@pytest.mark.parametrize(("exponent_bits", "fraction_bits"), [(4, 3), (3, 4)])
@pytest.mark.parametrize("op", FLOAT)
def test_every_pair_of_8_bit_operands_gives_symfpus_result(op, exponent_bits, fraction_bits):
    a, b = np.array(np.meshgrid(np.arange(256), np.arange(256))).reshape(2, -1)
    size = f"-op {op.name.lower()} -eb {exponent_bits} -sb {fraction_bits + 1}"
    expected = compiled(Symfpu(8, "a", "b", "o"), commands(f"symfpu {size}"))(op, a, b)
    result = compiled(FpOps(exponent_bits, fraction_bits, 8))(op, a, b)
    infinity = (2**exponent_bits - 1) << fraction_bits
    nan = expected & 0x7F > infinity
    assert np.array_equal(result & 0x7F > infinity, nan)
    assert np.array_equal(result[~nan], expected[~nan])


def test_every_16_bit_conversion_gives_symfpus_result():
    values = np.arange(2**16, dtype=np.uint32)
    unit = compiled(FpOps(5, 10, 16))
    before = commands("symfpu_convert -isize 16 -iexp 5 -osize 16 -oexp 5")
    to_float, to_int = (compiled(Symfpu(16, "i", "is_signed", output), before) for output in ("o_if", "o_fi"))
    assert np.array_equal(unit(Op.FROM_INT, values, values), to_float(0, values, values))
    exact = values.astype(np.uint16).view(np.float16)
    within = np.abs(exact) < 2**15  # saturation is ours
    assert within.sum() > 60000
    assert np.array_equal(unit(Op.TO_INT, values, values)[within], to_int(0, values, values)[within])
