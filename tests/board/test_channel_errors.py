"""Injected channel errors: as often as asked, logged, and the same however the stream is cut."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import cut, seeds

from repro.board.channel_errors import ErrorInjector, ErrorRates

pytestmark = pytest.mark.slow

CLEAN = np.random.default_rng(0).bytes(20_000)
ROUGH = ErrorRates(drop=0.01, flip=0.02, insert=0.03, stall=0.005, stall_s=0.25, stall_bytes=3)


@given(seed=seeds, sizes=st.lists(st.integers(0, 600), max_size=12))
def test_cutting_changes_nothing(seed, sizes):
    whole, pieces = (ErrorInjector(ROUGH, np.random.default_rng(seed)) for _ in range(2))
    sent = CLEAN[:4000]
    assert b"".join(map(pieces.apply, cut(sent, sizes))) == whole.apply(sent)
    assert (pieces.counts, pieces.stall_s) == (whole.counts, whole.stall_s)


@pytest.mark.parametrize(("kind", "change"), [("drop", -1), ("flip", 0), ("insert", 1)])
def test_each_kind_does_what_it_says_as_often_as_asked(kind, change):
    injector = ErrorInjector(ErrorRates(**{kind: 0.05}), np.random.default_rng(1))
    data = injector.apply(CLEAN)
    n = injector.counts[kind]
    assert len(data) == len(CLEAN) + change * n
    assert n == injector.counts.total()
    assert abs(n - 1000) < 4 * np.sqrt(950)
    if kind == "flip":  # any one bit of a byte, none more often than another
        flipped = [(a ^ b).bit_length() - 1 for a, b in zip(CLEAN, data, strict=True) if a != b]
        assert all(a ^ b in (0, *(1 << bit for bit in range(8))) for a, b in zip(CLEAN, data, strict=True))
        assert np.bincount(flipped) == pytest.approx(np.full(8, n / 8), abs=50)


def test_stalls_are_due_once_and_lose_their_bytes():
    injector = ErrorInjector(ErrorRates(stall=0.001, stall_s=0.5, stall_bytes=4), np.random.default_rng(3))
    data = injector.apply(CLEAN)
    n = injector.counts["stall"]
    assert n > 0 and len(data) == len(CLEAN) - 4 * n
    assert [injector.take_stall(), injector.take_stall()] == [0.5 * n, 0.0]
    # A byte arrives if neither it nor the one before stalls: a stall that begins within another loses no more.
    often = ErrorInjector(ErrorRates(stall=0.3, stall_bytes=2), np.random.default_rng(3)).apply(CLEAN)
    assert len(often) == pytest.approx(0.7**2 * len(CLEAN), rel=0.03)


@pytest.mark.parametrize("sizes", [[], [100, 20, 4000], [123, 1, 50]])
@pytest.mark.parametrize("after", [0, 1, 123, 124])
def test_disconnect(after, sizes):
    injector = ErrorInjector(ErrorRates(disconnect_after=after), np.random.default_rng(4))
    assert b"".join(map(injector.apply, cut(CLEAN, sizes))) == CLEAN[:after]
    assert injector.disconnected
