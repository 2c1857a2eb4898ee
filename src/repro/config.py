"""The configuration file, checked against its schema: one line for whatever is wrong."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import yaml

from repro.errors import InputError


def _finite(value: object, place: str) -> None:
    """Refuse NaN and infinity, which YAML can spell and a schema lets through."""
    if isinstance(value, Mapping):
        for key, item in value.items():
            _finite(item, f"{place}.{key}" if place else str(key))
    elif isinstance(value, list):
        for index, item in enumerate(value):
            _finite(item, f"{place}[{index}]")
    elif isinstance(value, float) and not np.isfinite(value):
        raise InputError.at(place, value, "a finite number")


def _origin(files: Iterable[Path], path: Iterable[str | int]) -> str:
    """Name of the last configuration file that sets `path`, or the command line."""
    origin = ""
    keys = [k for k in path if isinstance(k, str)]
    for file in files:
        node: object = yaml.safe_load(file.read_text(encoding="utf-8"))
        for key in keys:
            node = node.get(key) if isinstance(node, Mapping) else None
        if node is not None:
            origin = str(file)
    return origin or "configuration"


def _expected(error: jsonschema.ValidationError) -> tuple[str, str, str]:
    """Field, found and expected of a schema violation, in words."""
    field = ".".join(str(p) for p in error.absolute_path)
    rule, limit = str(error.validator), error.validator_value
    if rule == "additionalProperties":
        schema: Mapping[str, Any] = error.schema  # type: ignore[assignment]
        known = [*schema.get("properties", {}), *error.schema.get("required", [])]  # type: ignore[union-attr]
        unknown = [k for k in error.instance if k not in known]  # type: ignore[union-attr]
        field = ".".join([*(str(p) for p in error.absolute_path), str(unknown[0])])
        return field, "an unknown key", f"one of {', '.join(sorted(set(known)))}"
    if rule == "required":
        missing = next(k for k in limit if k not in error.instance)  # type: ignore[union-attr,operator]
        return ".".join(filter(None, [field, str(missing)])), "nothing", "a value"
    words = {
        "type": f"{limit}",
        "enum": f"one of {limit}",
        "const": f"{limit}",
        "minimum": f"at least {limit}",
        "maximum": f"at most {limit}",
        "exclusiveMinimum": f"more than {limit}",
        "exclusiveMaximum": f"less than {limit}",
        "minItems": f"at least {limit} values",
        "maxItems": f"at most {limit} values",
        "uniqueItems": "values that differ",
        "pattern": f"text like {limit}",
    }
    return field or "configuration", repr(error.instance), words.get(rule, f"{rule} {limit}")


def check_config(config: Mapping[str, Any], schema: Path, files: Iterable[Path] = ()) -> None:
    """Check a configuration against its schema.

    Parameters
    ----------
    config : mapping
        Merged configuration.
    schema : Path
        JSON schema in YAML.
    files : iterable of Path
        Configuration files in the order they were merged, to name the one at fault.

    Raises
    ------
    InputError
        At the first violation: file, field, found and expected in one line.
    """
    rules = yaml.safe_load(schema.read_text(encoding="utf-8"))
    violations = list(jsonschema.Draft202012Validator(rules).iter_errors(config))
    if violations:
        error = min(violations, key=lambda e: [str(p) for p in e.absolute_path])
        field, found, expected = _expected(error)
        raise InputError.at(f"{_origin(files, field.split('.'))}: {field}", found, expected)
    try:
        _finite(config, "")
    except InputError as error:
        raise InputError(f"{_origin(files, str(error).split(':')[0].split('.'))}: {error}") from error
