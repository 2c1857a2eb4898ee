"""The PD of Eq. 2 against single-precision arithmetic done with the standard library."""

import math
import struct

import numpy as np
from hypothesis import example, given
from hypothesis import strategies as st

from repro.board.controller import ControlConstants, PDController

TABLE_8 = ControlConstants((180.4817, 30.6819), (1270.7266, 102.2730), (1000.0, 1000.0), (2.7192, 2.7314))
DESIRED, COUNTS = st.floats(-4, 4, width=32), st.integers(-4200, 4200)


def single(x: float) -> float:
    """x rounded to IEEE single precision by the standard library."""
    return struct.unpack("f", struct.pack("f", x))[0]


def pwm_by_hand(kp: float, kv: float, desired: float, count: int, before: int) -> int:
    """One joint of Eq. 2. A sum or product of two singles rounds in double and then to single as it would at once."""
    step = single(2 * math.pi / 8400)
    q, q_before = single(single(count) * step), single(single(before) * step)
    u = single(single(kp * single(desired - q)) - single(kv * single(q - q_before)))
    return max(-1023, min(1023, round(u)))


@example([(0.0625, -0.03125, 5, -10), (0.0625, -0.5, 27, -31), (-3.0, 0.5, 27, -28)])
@given(st.lists(st.tuples(DESIRED, DESIRED, COUNTS, COUNTS), min_size=1, max_size=20))
def test_equals_arithmetic_by_hand(rows: list[tuple[float, float, int, int]]) -> None:
    controller = PDController(TABLE_8.kp_counts, TABLE_8.kv_counts)
    before = rows[0][2:]
    for *desired, first, second in rows:
        count = (first, second)
        pwm = controller(np.array([desired], dtype=np.float32).T, np.array([count]).T)
        for j in (0, 1):
            kp, kv = float(TABLE_8.kp_counts[j]), float(TABLE_8.kv_counts[j])
            assert pwm[j, 0] == pwm_by_hand(kp, kv, desired[j], count[j], before[j])
        before = count


def test_half_a_count_rounds_to_even() -> None:
    controller = PDController([1.0, 1.0], [1.0, 1.0])
    desired = np.array([[0.5], [1.5]], dtype=np.float32)
    assert controller(desired, np.zeros((2, 1), dtype=np.int32)).tolist() == [[0], [2]]
