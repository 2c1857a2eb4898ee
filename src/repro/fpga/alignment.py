"""Where frames begin: the checks of a single word and of a pair, and the choice between rival alignments."""

import struct

import numpy as np

from repro.fpga.frames import FRAME_BYTES, IDENTIFIER, split_words, valid_words

MARK = bytes([IDENTIFIER])
#: Bytes of a pair, in which the pair of another alignment must begin to be its rival.
RIVAL_SPAN = 2 * FRAME_BYTES
#: Bytes over which rivals are compared, and the lead that outweighs the alignment the search began with.
CONTEST_SPAN = 64 * FRAME_BYTES
CONTEST_LEAD = 3

#: Encoder counts of both joints.
Position = tuple[int, int]

# Identifier, two positions, then joint-1 torque (11 bit), joint-2 torque (11 bit) and two zero bits in 16 + 8 bits.
_FRAME = struct.Struct(">BhhHB")
# Frames from which on arrays are faster than a loop.
_FEW = 24


def candidate(data: bytes, o: int) -> Position | None:
    """Position held by the frame at `o` if it keeps the rules a frame can be checked by on its own, else None."""
    mark, q1, q2, high, low = _FRAME.unpack_from(data, o)
    # A torque of -1024 is a one and ten zeros: the top of `high`, or its last five bits and the top of `low`.
    if mark != IDENTIFIER or low & 0b11 or high >> 5 == 0x400 or (low == 0 and high & 0x1F == 0x10):
        return None
    return q1, q2


def fault(data: bytes, o: int) -> str:
    """Name the rule that the bytes at `o` break on their own, by the names of `Counts`; empty if they break none."""
    if data[o] != IDENTIFIER:
        return "identifier"
    if o + FRAME_BYTES > len(data):
        return "incomplete"
    if data[o + FRAME_BYTES - 1] & 0b11:
        return "zero_bits"
    return "" if candidate(data, o) else "torque"


def moved(a: Position, b: Position) -> int:
    """Counts by which the joint that moved most differs."""
    first, second = abs(a[0] - b[0]), abs(a[1] - b[1])
    return first if first > second else second


def count_run(data: bytes, o: int, rows: int, last: Position, max_step: int) -> int:
    """Count the candidates from `o` on, each near the one before it, the first near `last`."""
    if rows < _FEW:  # one by one is faster then, with the same result
        q1, q2 = last
        for n in range(rows):
            position = candidate(data, o + n * FRAME_BYTES)
            if not position or abs(position[0] - q1) > max_step or abs(position[1] - q2) > max_step:
                return n
            q1, q2 = position
        return rows
    words = np.frombuffer(data, ">u8", rows, o).astype(np.uint64)
    joints = np.empty((2, rows + 1), dtype=np.int32)
    joints[0, 0], joints[1, 0] = last
    joints[:, 1:] = split_words(words)[0]
    good = valid_words(words) & (np.abs(np.diff(joints)) <= max_step).all(axis=0)
    return rows if good.all() else int(np.argmin(good))


def find_pair(data: bytes, start: int, stop: int, max_step: int) -> int:
    """First place at which a candidate stands with another one right behind it that is near."""
    stop = min(stop, len(data) - 2 * FRAME_BYTES + 1)
    o = data.find(MARK, start, max(start, stop))
    while o >= 0:
        if data[o + FRAME_BYTES] == IDENTIFIER:
            first, second = candidate(data, o), candidate(data, o + FRAME_BYTES)
            if first and second and moved(first, second) <= max_step:
                return o
        o = data.find(MARK, o + 1, stop)
    return -1


def settle(data: bytes, pair: int, grid: int, max_step: int, final: bool) -> int | None:
    """Choose between the alignment of a pair and its rivals."""
    if not final and len(data) < pair + RIVAL_SPAN + 2 * FRAME_BYTES:
        return None
    rivals = {pair % FRAME_BYTES: pair}
    o = find_pair(data, pair + 1, pair + RIVAL_SPAN, max_step)
    while o >= 0:
        rivals.setdefault(o % FRAME_BYTES, o)
        o = find_pair(data, o + 1, pair + RIVAL_SPAN, max_step)
    if len(rivals) == 1:
        return pair
    if not final and len(data) < pair + CONTEST_SPAN + 2 * FRAME_BYTES:
        return None
    votes = {}
    for phase in rivals:
        first = pair + (phase - pair) % FRAME_BYTES
        places = range(first, min(first + CONTEST_SPAN, len(data) - FRAME_BYTES + 1), FRAME_BYTES)
        votes[phase] = sum(candidate(data, place) is not None for place in places)
    best = max(votes, key=lambda phase: (votes[phase], -rivals[phase]))
    grid %= FRAME_BYTES
    if grid in votes and votes[grid] > votes[best] - CONTEST_LEAD:
        best = grid
    return rivals[best]
