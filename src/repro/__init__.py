"""Reproduction of a CNN-based parameter identification of a two-joint robot arm.

The names below are the public API; everything else may change. They are loaded when they are first used.
"""

import importlib
import os
import sys
from typing import TYPE_CHECKING, Any

from repro import contract
from repro.errors import require

if TYPE_CHECKING:
    from repro.api import Identification as Identification
    from repro.api import identify as identify
    from repro.cnn.image import images as images
    from repro.cnn.network import load_network as load_network
    from repro.errors import InputError as InputError
    from repro.fpga.capture import read_capture as read_capture
    from repro.identification.algorithm1.search import SearchSettings as SearchSettings
    from repro.identification.algorithm1.search import algorithm1 as algorithm1
    from repro.identification.exciting_motion import excite as excite
    from repro.logs.armfile import Arm as Arm
    from repro.logs.armfile import read_arm as read_arm
    from repro.logs.load import read_log as read_log
    from repro.logs.log import Log as Log
    from repro.model.dynamics import inverse_dynamics as inverse_dynamics
    from repro.model.dynamics import regressor as regressor
    from repro.signals.dct import SignalSettings as SignalSettings
    from repro.signals.dct import dct2dev, dct2low
    from repro.signals.metric import metr2ev

    differentiate, low_pass, similarity = dct2dev, dct2low, metr2ev

__version__ = "0.1.0"

#: Module and name of each public object, by use.
_PUBLIC = {
    "identify": ("repro.api", "identify"),
    "Identification": ("repro.api", "Identification"),
    "Log": ("repro.logs.log", "Log"),
    "read_log": ("repro.logs.load", "read_log"),
    "Arm": ("repro.logs.armfile", "Arm"),
    "read_arm": ("repro.logs.armfile", "read_arm"),
    "excite": ("repro.identification.exciting_motion", "excite"),
    "regressor": ("repro.model.dynamics", "regressor"),
    "inverse_dynamics": ("repro.model.dynamics", "inverse_dynamics"),
    "similarity": ("repro.signals.metric", "metr2ev"),
    "low_pass": ("repro.signals.dct", "dct2low"),
    "differentiate": ("repro.signals.dct", "dct2dev"),
    "images": ("repro.cnn.image", "images"),
    "load_network": ("repro.cnn.network", "load_network"),
    "algorithm1": ("repro.identification.algorithm1.search", "algorithm1"),
    "SearchSettings": ("repro.identification.algorithm1.search", "SearchSettings"),
    "SignalSettings": ("repro.signals.dct", "SignalSettings"),
    "read_capture": ("repro.fpga.capture", "read_capture"),
    "InputError": ("repro.errors", "InputError"),
}
__all__ = list(_PUBLIC)


def __getattr__(name: str) -> Any:  # noqa: ANN401
    """Load a public name; without NumPy so far, under the numeric contract, as the command does."""
    if name not in _PUBLIC:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module, attribute = _PUBLIC[name]
    if "numpy" not in sys.modules:
        contract.hold(os.environ)
    if module == "repro.cnn.network":
        require("torch", "cnn", f"repro.{name}")
    return getattr(importlib.import_module(module), attribute)


def __dir__() -> list[str]:
    """List the public names."""
    return [*__all__, "__version__"]
