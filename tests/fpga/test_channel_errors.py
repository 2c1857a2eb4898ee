"""Injected channel errors: as often as asked, logged, and the same however the stream is cut."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import seeds

from repro.fpga.channel_errors import ChannelError, ErrorInjector, ErrorRates

pytestmark = pytest.mark.slow

CLEAN = np.random.default_rng(0).bytes(20_000)
ROUGH = ErrorRates(drop=0.01, flip=0.02, insert=0.03, stall=0.005, stall_s=0.25, stall_bytes=3)


def test_no_faults_change_nothing():
    injector = ErrorInjector(ErrorRates(), np.random.default_rng(0))
    assert injector.apply(CLEAN) == CLEAN
    assert (injector.log, injector.stall_s, injector.disconnected) == ([], 0.0, False)


@given(seed=seeds, sizes=st.lists(st.integers(0, 3000), max_size=12))
def test_cutting_changes_nothing(seed, sizes):
    whole, pieces = (ErrorInjector(ROUGH, np.random.default_rng(seed)) for _ in range(2))
    data, place = b"", 0
    for size in [*sizes, len(CLEAN)]:
        data += pieces.apply(CLEAN[place : place + size])
        place += size
    assert data == whole.apply(CLEAN)
    assert (pieces.log, pieces.stall_s) == (whole.log, whole.stall_s)


@pytest.mark.parametrize(("kind", "change"), [("drop", -1), ("flip", 0), ("insert", 1)])
def test_each_kind_does_what_it_says_as_often_as_asked(kind, change):
    injector = ErrorInjector(ErrorRates(**{kind: 0.05}), np.random.default_rng(1))
    data = injector.apply(CLEAN)
    n = injector.counts()[kind]
    assert len(data) == len(CLEAN) + change * n
    assert n == len(injector.log) == sum(injector.counts().values())
    assert abs(n - 1000) < 4 * np.sqrt(950)


def test_log_tells_where():
    injector = ErrorInjector(ErrorRates(drop=0.01), np.random.default_rng(2))
    data = injector.apply(CLEAN)
    lost = {error.offset for error in injector.log}
    assert data == bytes(byte for i, byte in enumerate(CLEAN) if i not in lost)
    injector = ErrorInjector(ErrorRates(flip=0.01), np.random.default_rng(2))
    data = injector.apply(CLEAN)
    struck = {i: (a ^ b).bit_count() for i, (a, b) in enumerate(zip(CLEAN, data, strict=True)) if a != b}
    assert struck == {error.offset: 1 for error in injector.log}


def test_stalls_are_due_once_and_lose_their_bytes():
    injector = ErrorInjector(ErrorRates(stall=0.001, stall_s=0.5, stall_bytes=4), np.random.default_rng(3))
    data = injector.apply(CLEAN)
    n = injector.counts()["stall"]
    assert n > 0
    assert len(data) == len(CLEAN) - 4 * n
    assert injector.take_stall() == 0.5 * n
    assert injector.take_stall() == 0.0


@pytest.mark.parametrize("sizes", [[20_000], [100, 20, 4000], [123, 1, 50]])
@pytest.mark.parametrize("after", [0, 1, 123, 124])
def test_disconnect(after, sizes):
    injector = ErrorInjector(ErrorRates(disconnect_after=after), np.random.default_rng(4))
    data, place = b"", 0
    for size in sizes:
        data += injector.apply(CLEAN[place : place + size])
        place += size
    assert data == CLEAN[:after]
    assert injector.disconnected
    assert injector.log == [ChannelError("disconnect", after)]


@pytest.mark.parametrize(
    ("rates", "name"),
    [
        ({"drop": -0.1}, "drop"),
        ({"flip": np.nan}, "flip"),
        ({"stall": 1.5}, "stall"),
        ({"drop": 0.5, "insert": 0.6}, "drop, flip"),
    ],
)
def test_rates_that_are_no_probabilities_are_refused(rates, name):
    with pytest.raises(ValueError, match=f"^{name}"):
        ErrorRates(**rates)
