"""What tests of several commands share."""

import resource

import pytest
from experiment_example import refusal_in

from repro.cli import main


@pytest.fixture
def refused(capsys):
    """Runs a command that refuses its input, and gives the error of its one line."""

    def error_of(*argv):
        assert main([*map(str, argv)]) == 2
        printed, errors = capsys.readouterr()
        assert printed == ""
        assert errors.count("\n") == 1
        return refusal_in(errors)

    return error_of


@pytest.fixture
def limit_files():
    """Limits the bytes of a file to a number, until the end of the test."""
    yield lambda size: resource.setrlimit(resource.RLIMIT_FSIZE, (size, resource.RLIM_INFINITY))
    resource.setrlimit(resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
