"""The allocator's limits: taken by glibc, and those of the environment left alone."""

import ctypes

import pytest

from repro.identification.algorithm1.own_network import LIMITS, keep_blocks

glibc = pytest.mark.skipif(not hasattr(ctypes.CDLL(None), "mallopt"), reason="the allocator is not glibc's")


@glibc
def test_glibc_takes_every_limit(monkeypatch):
    for _, variable, _ in LIMITS:
        monkeypatch.delenv(variable, raising=False)
    assert keep_blocks()


def test_an_allocator_without_limits_is_left_alone(monkeypatch):
    monkeypatch.setattr(ctypes, "CDLL", lambda name: object())
    assert not keep_blocks()


@glibc
def test_limits_of_the_environment_stay(monkeypatch):
    asked = []
    real = ctypes.CDLL(None)

    class Watched:
        def mallopt(self, number, value):
            asked.append(number)
            return real.mallopt(number, value)

    monkeypatch.setattr(ctypes, "CDLL", lambda name: Watched())
    monkeypatch.setenv(LIMITS[0][1], "1000000")
    for _, variable, _ in LIMITS[1:]:
        monkeypatch.delenv(variable, raising=False)
    assert keep_blocks()
    assert asked == [number for number, _, _ in LIMITS[1:]]
