"""The PD of Eq. 2 against golden vectors and against single-precision arithmetic done with the standard library."""

import math
import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from repro.fpga.controller import ControlConstants, PDController

TABLE_8 = ControlConstants((180.4817, 30.6819), (1270.7266, 102.2730), (1000.0, 1000.0), (2.7192, 2.7314))
COUNTS = st.integers(-4200, 4200)


def single(x: float) -> float:
    """x rounded to IEEE single precision by the standard library."""
    return struct.unpack("f", struct.pack("f", x))[0]


def pwm_by_hand(kp: float, kv: float, desired: float, count: int, before: int) -> int:
    """One joint of Eq. 2. A sum or product of two singles rounds in double and then to single as it would at once."""
    step = single(2 * math.pi / 8400)
    q, q_before = single(single(count) * step), single(single(before) * step)
    u = single(single(kp * single(desired - q)) - single(kv * single(q - q_before)))
    return max(-1023, min(1023, round(u)))


def run(desired: list[list[float]], counts: list[list[int]]) -> np.ndarray:
    controller = PDController(TABLE_8.kp_counts, TABLE_8.kv_counts)
    q_d = np.array(desired, dtype=np.float32).T[..., None]
    position = np.array(counts).T[..., None]
    return np.stack([controller(q_d[:, i], position[:, i])[:, 0] for i in range(len(counts))])


def test_golden_vectors() -> None:
    desired = [[0.0, 0.0], [0.01, -0.02], [0.015, -0.03], [0.02, 0.5], [0.02, -0.5], [-3.0, 0.001], [0.0, 0.0]]
    counts = [[0, 0], [5, -10], [12, -31], [26, -31], [27, -31], [27, -28], [-3, 1]]
    pwm = [[0, 0], [-1023, 143], [-1023, 523], [-1023, 1023], [-371, -1023], [-1023, 166], [1023, -839]]
    assert run(desired, counts).tolist() == pwm


@pytest.mark.slow
@given(st.lists(st.tuples(st.floats(-4, 4, width=32), COUNTS, COUNTS), min_size=1, max_size=20))
def test_equals_arithmetic_by_hand(rows: list[tuple[float, int, int]]) -> None:
    found = run([[d, d] for d, _, _ in rows], [[a, b] for _, a, b in rows])
    for i, (d, *count) in enumerate(rows):
        for j in (0, 1):
            kp, kv = float(TABLE_8.kp_counts[j]), float(TABLE_8.kv_counts[j])
            assert found[i, j] == pwm_by_hand(kp, kv, d, count[j], rows[max(i - 1, 0)][1 + j])


def test_half_a_count_rounds_to_even() -> None:
    controller = PDController([1.0, 1.0], [1.0, 1.0])
    desired = np.array([[0.5], [1.5]], dtype=np.float32)
    assert controller(desired, np.zeros((2, 1), dtype=np.int32)).tolist() == [[0], [2]]
