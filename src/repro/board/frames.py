"""The 64-bit uplink frame (Section III): one joint position and torque pair every 2.5 ms.

A frame is one big-endian 64-bit word, most significant bit first::

    63..56      55..40            39..24            23..13          12..2           1..0
    identifier  joint-1 position  joint-2 position  joint-1 torque  joint-2 torque  zero
    0xA5        int16, counts     int16, counts     11 bit, PWM     11 bit, PWM     00

All four numbers are two's complement. The controller saturates at +-1023 counts of PWM, so a torque of -1024
never occurs.
"""

import math
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

Int16Array = NDArray[np.int16]
SingleArray = NDArray[np.float32]

IDENTIFIER: Final = 0xA5
FRAME_BYTES: Final = 8
#: Encoder counts in a turn of a joint.
COUNTS_PER_TURN: Final = 8400
RADIANS_PER_COUNT: Final = 2.0 * math.pi / COUNTS_PER_TURN
#: Largest torque in PWM counts, either way.
PWM_LIMIT: Final = 1023
#: Time between frames, s.
SAMPLING_PERIOD: Final = 2.5e-3
#: Bits per second on the wire: 8 data bits, no parity, one stop bit.
BAUD: Final = 115200
#: Fastest a joint can turn, rad/s.
MAX_SPEED: Final = 8.0
#: Counts a joint can turn between frames: 8 rad/s x 2.5 ms, rounded up.
MAX_STEP: Final = math.ceil(MAX_SPEED * SAMPLING_PERIOD / RADIANS_PER_COUNT)

#: Bits that are the same in every frame, and their value.
FIXED_BITS: Final = 0xFF00000000000003
FIXED_VALUE: Final = IDENTIFIER << 56
#: Bits of each torque, and -1024 there.
TORQUE_BITS: Final = (0x7FF << 13, 0x7FF << 2)
TORQUE_NEVER: Final = (0x400 << 13, 0x400 << 2)
# From three bits up, the distance of each field above the low 16 bits.
_SHIFTS: Final = np.array([[43], [27], [11], [0]], dtype=np.uint64)


def encode(position: ArrayLike, pwm: ArrayLike) -> bytes:
    """Encode integer positions and torques, each (2, N) in counts, as N frames, oldest first."""
    q = _within("position", position, -(2**15), 2**15 - 1)
    tau = _within("pwm", pwm, -PWM_LIMIT, PWM_LIMIT)
    word = (q[0] & 0xFFFF) << 40 | (q[1] & 0xFFFF) << 24 | (tau[0] & 0x7FF) << 13 | (tau[1] & 0x7FF) << 2
    data: bytes = (word.astype(np.uint64) | np.uint64(FIXED_VALUE)).astype(">u8").tobytes()
    return data


def split_words(words: NDArray[np.uint64]) -> tuple[Int16Array, Int16Array]:
    """Extract positions and torques (2, N) from frames (N,), without checks."""
    # Each field is shifted to the low 16 bits, a torque to the top of those so that its sign is kept, and cut out.
    fields = (words << 3 >> _SHIFTS).astype(np.int16)
    fields[2:] >>= 5
    return fields[:2], fields[2:]


def is_valid(word: int) -> bool:
    """Whether the identifier and zero bits of a frame are right and its torques are not -1024."""
    (first, second), (never1, never2) = TORQUE_BITS, TORQUE_NEVER
    return word & FIXED_BITS == FIXED_VALUE and word & first != never1 and word & second != never2


def _within(name: str, values: ArrayLike, low: int, high: int) -> NDArray[np.int64]:
    array = np.asarray(values, dtype=np.int64)
    if (outside := array[(array < low) | (array > high)]).size:
        raise ValueError(f"{name}: must be in {low} ... {high}, got {outside[0]}.")
    return array
