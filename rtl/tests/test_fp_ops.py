"""The floating-point operations against NumPy's float32: random operands and all pairs of corners."""

import ctypes
from pathlib import Path

import numpy as np
import pytest

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


@pytest.fixture(scope="module")
def unit():
    library = compile_design(FpOps(), Path(__file__).with_name("fp_ops.cc"))
    library.run.restype = ctypes.c_uint64

    def run(op, a, b):
        a, b, result = (np.ascontiguousarray(x, dtype=np.uint32) for x in (a, b, np.zeros(len(a))))
        pointers = [x.ctypes.data_as(ctypes.c_void_p) for x in (a, b, result)]
        run.clocks = library.run(ctypes.c_uint32(op), ctypes.c_uint64(len(a)), *pointers)
        return result

    return run


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
