"""The numeric contract and one thread for every test, and how hypothesis draws."""

import os

from repro import contract

contract.hold(os.environ)  # before anything loads numpy
# Threads of torch that wait for each other take many times as long beside another process.
os.environ.setdefault("OMP_NUM_THREADS", "1")

import logging

import pytest
from hypothesis import settings

# Derandomised: the same examples on every machine, so a failure can be repeated.
settings.register_profile("repro", deadline=None, derandomize=True, max_examples=100, database=None)
settings.load_profile("repro")


@pytest.fixture(autouse=True)
def _no_handler_is_left_behind():
    """The command line logs to the standard error of its process, which is another one in the next test."""
    yield
    root = logging.getLogger()
    for handler in [handler for handler in root.handlers if type(handler) is logging.StreamHandler]:
        root.removeHandler(handler)


@pytest.fixture
def no_figures(monkeypatch):
    """Leave out the figures of `repro identify`, which take longer than all the rest: kept results show them."""
    monkeypatch.setattr("repro.fitting.outputs.figures_of", lambda result, curves: {})
