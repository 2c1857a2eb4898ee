"""Progress of long work, by a clock that the test moves."""

import logging
from types import SimpleNamespace

import pytest

from repro.progress import Progress


@pytest.fixture
def clock(monkeypatch, caplog):
    caplog.set_level(logging.INFO, logger="repro.progress")
    clock = SimpleNamespace(now=1000.0)
    monkeypatch.setattr("repro.progress.time", SimpleNamespace(monotonic=lambda: clock.now))
    return clock


def test_lines_come_no_closer_than_asked_for(clock, caplog):
    progress = Progress("training")
    at = []
    for done in range(1, 31):
        clock.now += 1.0
        progress(done, 100)
        at += [done] * (len(caplog.messages) - len(at))
    assert at == list(range(3, 31, 3))


def test_the_last_line_always_comes(clock, caplog):
    progress = Progress("training")
    for done in (1, 2, 3):
        clock.now += 0.1
        progress(done, 3)
    assert caplog.messages == ["training: 3 of 3 (100 %)"]


def test_a_line_says_how_long_the_rest_takes_at_the_speed_since_the_checkpoint(clock, caplog):
    progress = Progress("training")
    clock.now += 2.0
    progress(9000, 10_000)
    clock.now += 10.0
    progress(9100, 10_000)  # 10 a second, 900 to go: 90 s, not 1
    assert caplog.messages == ["training: 9100 of 10000 (91 %), about 90 s left"]
