"""The numeric contract and one thread for every test, and how hypothesis draws."""

import os

from repro import contract

contract.hold(os.environ)  # before anything loads numpy
# Threads of torch that wait for each other take many times as long beside another process.
os.environ.setdefault("OMP_NUM_THREADS", "1")

from hypothesis import settings

# Derandomised: the same examples on every machine, so a failure can be repeated.
settings.register_profile("repro", deadline=None, derandomize=True, max_examples=100, database=None)
settings.load_profile("repro")
