"""The numeric contract for every test, and how hypothesis draws."""

import os

from repro import contract

contract.hold(os.environ)  # before anything loads numpy

from hypothesis import settings

# Derandomised: the same examples on every machine, so a failure can be repeated.
settings.register_profile("repro", deadline=None, derandomize=True, max_examples=100, database=None)
settings.load_profile("repro")
