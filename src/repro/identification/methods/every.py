"""The methods that solve a regression, by name."""

from importlib import import_module

from repro.identification.methods.interface import Method
from repro.identification.methods.names import names

METHODS: dict[str, Method] = {name: import_module(f"repro.identification.methods.{name}").METHOD for name in names()}
