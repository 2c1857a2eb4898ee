"""Our value for each published number, from the columns ``ours`` and ``note`` of ``published.csv``.

======================= ================================================================================
``config:EXPR``          keys of the configuration
``schedule:EXPR``        keys of the paper's training schedule, which the default network does not use
``const:MODULE:EXPR``    names of a module of this package
``arithmetic:EXPR``      keys of the configuration, names of `MODULES`, other printed numbers and the audit
``result:SOURCE``        result files (`repro.paper.results`)
``bench``                nothing: a property of the authors' arm, board or bench
======================= ================================================================================

An expression is arithmetic on names, their attributes and items, calls without arguments, and `FUNCTIONS`. In a note,
``{EXPR}`` is replaced by its value.
"""

import ast
import math
import operator
import re
from collections.abc import Callable, Mapping
from types import ModuleType
from typing import Any

import numpy as np

from repro.cnn import architecture, image, priors
from repro.comparison.tolerances import LEDGER
from repro.errors import InputError
from repro.fpga import frames
from repro.model import dynamics, parameters, stability
from repro.paper import audit as hardware
from repro.paper.claims import Basis, OurValue
from repro.paper.published import Published, PublishedValue
from repro.signals import programs, trajectories, validation_motions
from repro.signals.metric import metr2ev

CONFIG_FILE = "config/config.yaml"
#: Modules by their names in the column; what two modules share is looked up where it is defined.
MODULES: dict[str, ModuleType] = {
    "cnn.architecture": architecture,
    "cnn.image": image,
    "cnn.network": architecture,
    "cnn.priors": priors,
    "fpga.frames": frames,
    "identification.algorithm1": parameters,
    "model.dynamics": dynamics,
    "model.stability": stability,
    "signals.programs": programs,
    "signals.trajectories": trajectories,
    "signals.validation_motions": validation_motions,
}
#: Causes of differences that the arithmetic leaves.
CAUSE_OF = {"section3/memory-share": "unlisted memory"}
_OPERATORS: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
    ast.RShift: operator.rshift,
}


def _count(entries: Mapping[str, object], attribute: str) -> int:
    return sum(getattr(entry, attribute) for entry in entries.values())


def _self_similarity() -> float:
    signal = np.sin(np.arange(1.0, 100.0))
    return float(metr2ev(signal, signal).total)


FUNCTIONS: dict[str, Callable[..., Any]] = {
    "count": _count,
    "len": len,
    "round": round,
    "self_similarity": _self_similarity,
    "sum": sum,
}


def evaluate(expression: str, names: Mapping[str, Any]) -> Any:  # noqa: ANN401
    """Evaluate an expression of the grammar above."""
    return _value(ast.parse(expression, mode="eval").body, names)


def _value(node: ast.expr, names: Mapping[str, Any]) -> Any:  # noqa: ANN401
    result: Any
    match node:
        case ast.Constant():
            result = node.value
        case ast.Name(id=name):
            result = names[name]
        case ast.Attribute(value=owner, attr=name) if not name.startswith("_"):
            parent = _value(owner, names)
            result = parent[name] if isinstance(parent, Mapping) else getattr(parent, name)
        case ast.Subscript(value=owner, slice=key):
            result = _value(owner, names)[_value(key, names)]
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            result = -_value(operand, names)
        case ast.BinOp(left=left, op=op, right=right) if type(op) in _OPERATORS:
            result = _OPERATORS[type(op)](_value(left, names), _value(right, names))
        case ast.Call(func=ast.Name(id=name), args=arguments, keywords=[]) if name in FUNCTIONS:
            result = FUNCTIONS[name](*(_value(argument, names) for argument in arguments))
        case ast.Call(func=function, args=[], keywords=[]):
            result = _value(function, names)()
        case _:
            raise ValueError(f"{ast.unparse(node)} is no arithmetic on names")
    return result


def _first_key(expression: str, config: Mapping[str, Any]) -> str:
    """Return the first key of the configuration in an expression, without indices of list items."""
    dotted = re.sub(r"\['([\w-]+)'\]", r".\1", expression)
    keys: list[str] = re.findall(r"[a-z][\w-]*(?:\.[\w-]+)+", dotted)
    return next(key for key in keys if key.partition(".")[0] in config)


def declared_value(
    number: PublishedValue, published: Published, config: Mapping[str, Any], audit: Mapping[str, float]
) -> OurValue:
    """Compute our value of a number whose source is not a result file; `audit` has the values found, by finding."""
    source, _, expression = number.ours.partition(":")
    if source == "bench":
        return OurValue(None, "", note=number.note)
    module, names = "", {"pi": math.pi, **config}
    if source == "const":
        module, _, expression = expression.partition(":")
        names = vars(MODULES[module]) if module in MODULES else {}
    elif source == "arithmetic":
        names |= {"frames": frames, "programs": programs, "hardware": hardware, "audit": audit}
        names["printed"] = {each.id: each.value for each in published}
    elif source in ("config", "schedule"):
        names["CIRCLE_RADIUS"] = validation_motions.CIRCLE_RADIUS
    else:
        expected = "config, schedule, const, arithmetic, result or bench"
        raise InputError.at(f"{published.source}: {number.id}: ours", repr(number.ours), expected)
    try:
        value = float(evaluate(expression, names))
    except (ValueError, TypeError, LookupError, AttributeError, SyntaxError) as error:
        expected = "arithmetic on known names"
        raise InputError.at(f"{published.source}: {number.id}: ours", f"{number.ours} ({error})", expected) from error
    if source == "arithmetic":
        note = re.sub(
            r"\{([^:}]+)(?::([^}]+))?\}", lambda match: format(evaluate(match[1], names), match[2] or "g"), number.note
        )
        return OurValue(value, LEDGER, Basis.ARITHMETIC, cause=CAUSE_OF.get(number.id, ""), note=note)
    if source == "const":
        return OurValue(value, LEDGER, strict=True, note="; ".join(filter(None, (number.note, "repro." + module))))
    note = ", ".join(filter(None, (f"{CONFIG_FILE}: {_first_key(expression, config)}", number.note)))
    unused = source == "schedule" and config["training"]["recipe"] != "paper"
    return OurValue(value, LEDGER, strict=True, unused=unused, note=note)
