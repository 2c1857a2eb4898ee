"""The methods that solve a regression: every file of this folder that is named in `repro.estimators.names`."""

from importlib import import_module

from repro.estimators.interface import Method
from repro.estimators.names import names

METHODS: dict[str, Method] = {name: import_module(f"repro.estimators.{name}").METHOD for name in names()}
