"""The optional back end in the folder ``rtl`` of a checkout: a board whose design in logic is simulated."""

import importlib
import os
import shutil
import sys
from pathlib import Path

from repro.errors import InputError
from repro.fpga.server import Board

_CHECKOUT = Path(__file__).resolve().parents[3]


def logic_board() -> type[Board]:
    """Load the class of the board in logic; InputError if something that it needs is not installed."""
    compiler = os.environ.get("CXX", "g++")
    if shutil.which(compiler) is None:
        raise InputError.at("board rtl", f"no compiler {compiler}", "one of C++, such as Debian's g++")
    sys.path.append(str(_CHECKOUT))
    try:
        board: type[Board] = importlib.import_module("rtl.loop").LogicBoard
    except ModuleNotFoundError as error:
        expected = "a checkout of the project, installed by: pip install -e '.[rtl]'"
        raise InputError.at("board rtl", f"no module {error.name}", expected) from error
    finally:
        sys.path.remove(str(_CHECKOUT))
    return board
