"""The stream parser: what it finds in damaged, ambiguous and senseless streams."""

from collections import Counter

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import cut, seeds

from repro.board.channel_errors import ErrorInjector, ErrorRates
from repro.board.frames import encode
from repro.board.parser import REASONS, WINDOW, StreamParser


def motion(n, speed=9.0, seed=0):
    """Frames of a smooth motion with torque noise; `speed` in counts a frame."""
    rng = np.random.default_rng(seed)
    t = np.arange(n)
    position = np.rint(np.array([[150.0], [-90.0]]) + np.cumsum(speed * np.cos(np.outer([0.021, 0.033], t)), axis=1))
    pwm = np.rint(np.outer([400, 250], np.sin(0.02 * t)) + rng.normal(0, 20, (2, n)))
    return encode(position.astype(int), pwm.astype(int))


def at_rest(n, position=(165, 300)):
    """Frames of an arm that stands still where a second alignment is possible."""
    return encode(np.tile(position, (n, 1)).T, np.tile((40, -7), (n, 1)).T)


def parse(data, sizes=()):
    parser = StreamParser()
    pieces = [*map(parser.feed, cut(data, sizes)), parser.finish()]
    words = [encode(f.position, f.pwm) for f in pieces]
    frames = [w[i : i + 8] for w in words for i in range(0, len(w), 8)]
    offsets = np.concatenate([f.offset for f in pieces]).tolist()
    assert all(data[o : o + 8] == frame for o, frame in zip(offsets, frames, strict=True))
    return frames, offsets, parser.gaps, parser.counts


def cost(sent, frames):
    """Frames of `sent` that were not found, and frames found that were not sent."""
    was, now = Counter(sent[i : i + 8] for i in range(0, len(sent), 8)), Counter(frames)
    return (was - now).total(), (now - was).total()


def check_books(data, frames, gaps, counts):
    assert counts.received == len(data) == 8 * counts.good + counts.skipped
    assert (counts.good, counts.gaps, counts.lost) == (len(frames), len(gaps), sum(g.lost for g in gaps))
    assert counts.skipped == sum(getattr(counts, reason) for reason in REASONS) == sum(g.skipped for g in gaps)


@given(seed=seeds, sizes=st.lists(st.integers(0, 300) | st.integers(0, 9), max_size=60))
def test_cutting_changes_nothing(seed, sizes):
    rng = np.random.default_rng(seed)
    rates = ErrorRates(drop=0.004, flip=0.004, insert=0.004, stall=0.001, stall_bytes=int(rng.integers(0, 90)))
    data = ErrorInjector(rates, rng).apply(motion(120, speed=rng.uniform(0, 25), seed=seed))
    whole = parse(data)
    assert parse(data, sizes) == whole
    check_books(data, whole[0], *whole[2:])


STREAMS = {"motion": motion(15), "fast": motion(15, speed=26.0), "rest": at_rest(8) + motion(8)}


@pytest.mark.parametrize("name", STREAMS)
@pytest.mark.parametrize(
    "value", [None, *(pytest.param(value, marks=pytest.mark.slow) for value in (0x00, 0xA5, 0xFF))]
)
def test_one_byte_lost_or_inserted_costs_two_frames_at_most(name, value):
    sent = STREAMS[name]
    for i in range(len(sent)):
        damaged = sent[:i] + (sent[i + 1 :] if value is None else bytes([value]) + sent[i:])
        missing, wrong = cost(sent, parse(damaged)[0])
        assert missing <= 2 and wrong == 0, i


@pytest.mark.slow
@pytest.mark.parametrize("name", STREAMS)
def test_one_bit_flipped_costs_two_frames_at_most(name):
    sent = STREAMS[name]
    for i in range(len(sent)):
        for bit in range(8):
            data = bytearray(sent)
            data[i] ^= 1 << bit
            missing, wrong = cost(sent, parse(bytes(data))[0])
            assert missing <= 2 and wrong <= 1, (i, bit)
            # Identifier, zero bits and the top half of a position are always noticed.
            if i % 8 in (0, 1, 3) or (i % 8 == 7 and bit < 2):
                assert wrong == 0, (i, bit)


def test_random_bytes_hold_no_frame():
    data = np.random.default_rng(1).bytes(10_000_000)
    parser = StreamParser()
    assert len(parser.feed(data)) + len(parser.finish()) == 0  # 7e-13 a byte are expected
    assert parser.counts.skipped == len(data)


@pytest.mark.slow
@given(body=st.lists(st.sampled_from([0xA5, 0x00, 0x01, 0x28, 0x80, 0x10]), max_size=600))
def test_no_bytes_full_of_identifiers_are_too_strange(body):
    data = bytes(body)
    frames, _, gaps, counts = parse(data, [7] * (len(data) // 7))
    check_books(data, frames, gaps, counts)


@pytest.mark.parametrize("noise", [1, 5, 63, 64, 65, 1000])
def test_noise_between_frames(noise):
    head, tail = motion(30), motion(30, seed=3)
    data = head + b"\x11" * noise + tail
    frames, _, gaps, _ = parse(data)
    # The frame before the noise cannot be told from one with a byte inserted.
    assert b"".join(frames) == head[:-8] + tail
    assert [(g.offset, g.skipped, g.next_frame) for g in gaps] == [(29 * 8, 8 + noise, 29)]


def test_arm_at_rest_has_two_alignments_and_the_first_byte_decides():
    data = at_rest(200)
    assert b"".join(parse(data)[0]) == data
    # The other one reads the same bytes two later: nothing but where the recording began tells them apart.
    other = parse(data[2:])
    assert other[1][:3] == [0, 8, 16]


@pytest.mark.parametrize("drop", range(1, 8))
def test_short_ambiguity_is_settled_by_what_follows(drop):
    sent = at_rest(20) + motion(100)
    frames, offsets, _, _ = parse(sent[drop:])
    assert (offsets[0], b"".join(frames)) == (8 - drop, sent[8:])


@pytest.mark.parametrize(
    ("position", "skipped", "gap"),
    [
        # A frame too far from the last one, though the next is near; the gap is its offset, its bytes and frames lost.
        ([*[100] * 10, 140, *[120] * 9], [10], (80, 8, 1)),
        # A jump: 540 counts take 20 frames at 27 counts a frame.
        ([*[100] * 50, *[640] * 50], [], (400, 0, 19)),
        # At 20 counts a frame a bit of 32 the other way makes a step of -12, which is possible; the next is not near.
        (20 * np.arange(40) - 32 * (np.arange(40) == 20), [], (168, 0, 1)),
    ],
)
def test_a_step_that_no_joint_can_make_is_a_gap(position, skipped, gap):
    data = encode([position, np.zeros(len(position), dtype=int)], np.zeros((2, len(position)), dtype=int))
    frames, _, gaps, counts = parse(data)
    kept = np.delete(np.arange(len(position)), skipped)
    assert frames == [data[8 * i : 8 * i + 8] for i in kept]
    assert [(g.offset, g.skipped, g.lost, g.reason) for g in gaps] == [(*gap, "step")]
    check_books(data, frames, gaps, counts)


def test_false_lock_ends_when_the_arm_moves():
    moving = motion(100)
    data = (at_rest(150) + moving)[2:]
    frames, _, gaps, _ = parse(data)
    assert b"".join(frames).endswith(moving[16:])
    assert len(gaps) <= 3


def test_each_reason_is_counted():
    sent = [motion(12)[i : i + 8] for i in range(0, 96, 8)]
    for reason, i, value in [("identifier", 0, 0x00), ("zero_bits", 7, 0x03), ("step", 1, 0x40)]:
        frame = bytearray(sent[6])
        frame[i] ^= value or frame[i]
        *_, gaps, counts = parse(b"".join([*sent[:6], frame, *sent[7:]]))
        assert [(g.offset, g.skipped, g.lost, g.reason) for g in gaps] == [(48, 8, 1, reason)]
    for skipped, lost in ((19, 2), (20, 3)):  # to the nearest whole number of frames, halves up
        *_, gaps, _ = parse(b"".join([*sent[:6], bytes(skipped - 8), *sent[7:]]))
        assert [(g.skipped, g.lost) for g in gaps] == [(skipped, lost)]
        assert getattr(counts, reason) >= 1
    for torques in ("800000", "001000"):  # -1024 of joint 1, of joint 2
        never = sent[6][:5] + bytes.fromhex(torques)
        frames, _, gaps, _ = parse(b"".join([*sent[:6], never, *sent[7:]]))
        assert [g.reason for g in gaps] == ["torque"]
        assert frames == [*sent[:6], *sent[7:]]


def test_last_frame_waits_for_the_byte_after_it():
    data = motion(10)
    parser = StreamParser()
    assert [len(frames) for frames in (parser.feed(data), parser.finish(), parser.finish())] == [9, 1, 0]


def test_frames_are_lost_for_one_window_at_most_after_noise_that_looks_good():
    sent = motion(80)
    false = at_rest(3, (9000, 9000))
    frames, *_ = parse(sent[:320] + false + sent[320:])
    assert b"".join(frames).endswith(sent[320:])
    assert WINDOW == 64


@pytest.mark.slow
def test_many_faults_are_counted_and_wrong_frames_stay_within_the_bound():
    rate, n, patterns = 1e-3, 200, 1000
    rng = np.random.default_rng(7)
    wrong = flips = 0
    for seed in range(patterns):
        sent = motion(n, seed=seed % 20)
        injector = ErrorInjector(ErrorRates(drop=rate, flip=rate, insert=rate), rng)
        data = injector.apply(sent)
        done = injector.counts
        frames, _, gaps, counts = parse(data)
        check_books(data, frames, gaps, counts)
        missing, unsent = cost(sent, frames)
        # Every lost or added byte leaves a gap, every missing frame lies in one, and each fault costs two at most.
        assert gaps or not done["drop"] + done["insert"]
        assert gaps or counts.good == n
        assert missing <= 2 * (done["drop"] + done["insert"] + done["flip"])
        wrong += unsent
        flips += done["flip"]
    # A flip is unseen in 22 torque and at most 12 low position bits of 64; two faults in a frame can make up for each
    # other, which (8 x 3 rate)^2 bounds.
    bound = 34 / 64 * flips + (24 * rate) ** 2 * n * patterns
    assert 0.3 * flips < wrong < bound + 3 * np.sqrt(bound)
