"""The prior of the parameters: read from a file or a mapping, and completed by the plane of the arm."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from repro.documents import read_json
from repro.errors import InputError
from repro.identification.armfile import Arm
from repro.identification.regression import Prior
from repro.model.parameters import NAMES, UNITS

MAX_PARAMETER, MIN_SD = 1e9, 1e-6  # largest parameter, and smallest standard deviation that is not zero
#: Parameters that no arm has below zero; the signs of the others depend on where masses and the zero position are.
NOT_NEGATIVE = ("I1", "I3", "b1", "b2", "k1", "k2")
HALF_95 = 1.96  # half of a 95 % interval over its standard deviation


def read_result(place: str, content: Any) -> list[dict[str, Any]]:  # noqa: ANN401
    """Give the nine parameters of the recommended method of a result."""
    try:
        index = [method["method"] for method in content["methods"]].index(content["recommended"])
        parameters = list(content["methods"][index]["parameters"])
    except (KeyError, ValueError, TypeError) as error:
        raise InputError.at(place, "no recommended method", "parameters.json of repro identify") from error
    place = f"{place}: methods[{index}].parameters"
    if len(parameters) != len(NAMES):
        raise InputError.at(place, f"{len(parameters)} parameters", f"{len(NAMES)}: {', '.join(NAMES)}")
    for k, parameter in enumerate(parameters):
        row = parameter if isinstance(parameter, dict) else {}
        for key, wanted in (("name", NAMES[k]), ("unit", UNITS[k])):
            if row.get(key) != wanted:
                raise InputError.at(f"{place}[{k}].{key}", ascii(row.get(key))[:60], repr(wanted))
        _number(f"{place}[{k}].estimate", row.get("estimate"), -MAX_PARAMETER)
    return parameters


def read_prior(source: str | Path | Mapping[str, Any]) -> Prior:
    """Read a prior: a result, of which each 95 % interval counts, or ``{"g1": {"value": 1.0, "sd": 0.1}}``."""
    place, content = ("prior", source) if isinstance(source, Mapping) else (str(source), read_json(Path(source)))
    mean, sd = np.zeros(len(NAMES)), np.full(len(NAMES), np.inf)
    if isinstance(content, Mapping) and "methods" in content:
        for k, parameter in enumerate(read_result(place, content)):
            ends = {end: parameter.get(end) for end in ("low", "high")}
            if None not in ends.values():
                low, high = (_number(f"{place}: {NAMES[k]}.{end}", x, -MAX_PARAMETER) for end, x in ends.items())
                if low > high:
                    raise InputError.at(f"{place}: {NAMES[k]}.low", low, f"a number up to high, {high}")
                mean[k], sd[k] = parameter["estimate"], max((high - low) / (2.0 * HALF_95), MIN_SD)
    elif isinstance(content, Mapping):
        for name, entry in content.items():
            if name not in NAMES:
                raise InputError.at(f"{place}: {str(name)[:40]}", "no parameter", f"one of {', '.join(NAMES)}")
            if not isinstance(entry, Mapping) or set(entry) != {"value", "sd"}:
                expected = "value and sd, such as {'value': 1, 'sd': 0.1}"
                raise InputError.at(f"{place}: {name}", ascii(entry)[:60], expected)
            k, least = NAMES.index(name), 0.0 if name in NOT_NEGATIVE else -MAX_PARAMETER
            mean[k] = _number(f"{place}: {name}.value", entry["value"], least)
            sd[k] = _number(f"{place}: {name}.sd", entry["sd"], 0.0)
            if 0.0 < sd[k] < MIN_SD:
                expected = f"0 for a known value, or {MIN_SD:g} and more"
                raise InputError.at(f"{place}: {name}.sd", entry["sd"], expected)
    if not np.isfinite(sd).any():
        raise InputError.at(place, "no parameter with a standard deviation", "a result with intervals, or value and sd")
    return Prior(mean, sd)


def with_plane(prior: Prior | None, arm: Arm) -> Prior | None:
    """Add that gravity turns no joint in a horizontal plane."""
    if arm.plane != "horizontal":
        return prior
    gravity = np.isin(NAMES, ("g1", "g2"))
    mean, sd = (np.zeros(len(NAMES)), np.full(len(NAMES), np.inf)) if prior is None else (prior.mean, prior.sd)
    if np.isfinite(sd[gravity]).any() and np.any(mean[gravity] != 0.0):
        raise InputError.at("prior: g1, g2", mean[gravity].tolist(), "none, because the plane of the arm is horizontal")
    return Prior(np.where(gravity, 0.0, mean), np.where(gravity, 0.0, sd))


def _number(place: str, value: object, least: float) -> float:
    number = isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(value, bool)
    if not (number and least <= value <= MAX_PARAMETER):  # type: ignore[operator]
        sizes = f"of at most {MAX_PARAMETER:g}" if least < 0.0 else f"from 0 to {MAX_PARAMETER:g}"
        raise InputError.at(place, repr(value)[:60], f"a number {sizes}")
    return float(value)  # type: ignore[arg-type]
