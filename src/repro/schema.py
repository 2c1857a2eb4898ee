"""What a JSON schema does not allow, in words: where, what was found, what was expected."""

import math
from collections.abc import Iterator, Mapping
from typing import Any

import jsonschema

#: Keys and list positions that lead to a value.
Place = tuple[str | int, ...]

# JSON takes 60.0 for an integer; a budget written so would fail later, far from here.
_TYPES = jsonschema.Draft202012Validator.TYPE_CHECKER.redefine(
    "integer", lambda _, value: isinstance(value, int) and not isinstance(value, bool)
)
_Validator = jsonschema.validators.extend(jsonschema.Draft202012Validator, type_checker=_TYPES)  # type: ignore[no-untyped-call]


def spelled(place: Place) -> str:
    """``("numeric", "arms", "N1", 3)`` as ``numeric.arms.N1[3]``; a key of points alone in quotes."""

    def part(key: str | int) -> str:
        return f"[{key!r}]" if isinstance(key, int) or not key.strip(".") else f".{key}"

    return "".join(map(part, place)).removeprefix(".")


def violation(content: object, schema: Mapping[str, Any]) -> tuple[Place, object, str] | None:
    """Place, found and expected of the first violation, by place; NaN and infinity are violations everywhere.

    What is expected is the schema's own description of the value, where it has one.
    """
    errors = _Validator(schema).iter_errors(content)  # one at a time: there may be millions
    if first := min(errors, key=lambda error: [str(key) for key in error.absolute_path], default=None):
        return _words(first, schema)
    return next(((place, value, "a finite number") for place, value in _infinite(content)), None)


def _words(error: jsonschema.ValidationError, schema: Mapping[str, Any]) -> tuple[Place, str, str]:
    place, instance = tuple(error.absolute_path), error.instance
    rule, limit, own = str(error.validator), error.validator_value, error.schema
    if rule == "additionalProperties":
        known = [*own.get("properties", {}), *own.get("required", [])]  # type: ignore[union-attr]
        unknown = next(key for key in instance if key not in known)  # type: ignore[union-attr]
        return (*place, str(unknown)), "an unknown key", f"one of {', '.join(dict.fromkeys(known))}"
    if rule == "required":
        missing = next(key for key in limit if key not in instance)  # type: ignore[union-attr,operator]
        return (*place, str(missing)), "nothing", "a value"
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
        "not": "another key",
    }
    described = own.get("description") if isinstance(own, Mapping) else None
    return place, repr(instance)[:60], described or _described(schema, place) or words.get(rule, f"{rule} {limit}")


def _described(schema: Mapping[str, Any], place: Place) -> str:
    """Description of the value at a place, or of the innermost one around it that the schema names."""
    node = schema
    for key in place:
        if key not in node.get("properties", {}):
            break
        node = node["properties"][key]
    return str(node.get("description", ""))


def _infinite(node: object, place: Place = ()) -> Iterator[tuple[Place, float]]:
    """Places of NaN and infinity, which YAML and Python's JSON can spell and a schema lets through."""
    if isinstance(node, Mapping):
        for key, item in node.items():
            yield from _infinite(item, (*place, str(key)))
    elif isinstance(node, list):
        for index, item in enumerate(node):
            yield from _infinite(item, (*place, index))
    elif isinstance(node, float) and not math.isfinite(node):
        yield place, node
