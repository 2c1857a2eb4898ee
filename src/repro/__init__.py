"""Reproduction of a CNN-based parameter identification of a two-joint robot arm.

The names below are the public API; everything else may change. They are loaded when they are first used.
"""

import importlib
import os
import sys
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from repro.board.capture import read_capture
    from repro.cnn.image import images
    from repro.cnn.network import estimate_residuals, load_network
    from repro.errors import InputError
    from repro.fitting.api import identify
    from repro.fitting.identification import Identification
    from repro.identification.algorithm1.search import SearchSettings, algorithm1
    from repro.identification.armfile import Arm, read_arm
    from repro.identification.exciting_motion import excite
    from repro.identification.log import Log
    from repro.logs.load import read_log
    from repro.model.dynamics import inverse_dynamics, regressor
    from repro.signals.dct import SignalSettings
    from repro.signals.dct import dct2dev as differentiate
    from repro.signals.dct import dct2low as low_pass
    from repro.signals.metric import metr2ev as similarity

__version__ = "0.2.0"

#: Module and name of each public object.
_PUBLIC = {
    "Arm": ("repro.identification.armfile", "Arm"),
    "Identification": ("repro.fitting.identification", "Identification"),
    "InputError": ("repro.errors", "InputError"),
    "Log": ("repro.identification.log", "Log"),
    "SearchSettings": ("repro.identification.algorithm1.search", "SearchSettings"),
    "SignalSettings": ("repro.signals.dct", "SignalSettings"),
    "algorithm1": ("repro.identification.algorithm1.search", "algorithm1"),
    "differentiate": ("repro.signals.dct", "dct2dev"),
    "estimate_residuals": ("repro.cnn.network", "estimate_residuals"),
    "excite": ("repro.identification.exciting_motion", "excite"),
    "identify": ("repro.fitting.api", "identify"),
    "images": ("repro.cnn.image", "images"),
    "inverse_dynamics": ("repro.model.dynamics", "inverse_dynamics"),
    "load_network": ("repro.cnn.network", "load_network"),
    "low_pass": ("repro.signals.dct", "dct2low"),
    "read_arm": ("repro.identification.armfile", "read_arm"),
    "read_capture": ("repro.board.capture", "read_capture"),
    "read_log": ("repro.logs.load", "read_log"),
    "regressor": ("repro.model.dynamics", "regressor"),
    "similarity": ("repro.signals.metric", "metr2ev"),
}

#: The same names, written out for type checkers.
__all__ = [  # noqa: RUF022  (by use)
    "identify",
    "Identification",
    "Log",
    "read_log",
    "Arm",
    "read_arm",
    "excite",
    "regressor",
    "inverse_dynamics",
    "similarity",
    "low_pass",
    "differentiate",
    "images",
    "load_network",
    "estimate_residuals",
    "algorithm1",
    "SearchSettings",
    "SignalSettings",
    "read_capture",
    "InputError",
]


def __getattr__(name: str) -> Any:  # noqa: ANN401
    """Load a public name; without NumPy so far, under the numeric contract, as the command does."""
    try:
        module, attribute = _PUBLIC[name]
    except KeyError:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}") from None
    if "numpy" not in sys.modules:
        from repro import contract  # noqa: PLC0415

        contract.hold(os.environ)
    if module.startswith("repro.cnn.network"):
        from repro.errors import require  # noqa: PLC0415

        require("torch", "cnn", f"repro.{name}")
    return getattr(importlib.import_module(module), attribute)


def __dir__() -> list[str]:
    """List the public names."""
    return [*__all__, "__version__"]
