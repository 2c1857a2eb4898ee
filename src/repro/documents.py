"""YAML and JSON files that a user writes: limited in size, depth and digits, each key once, and valid by a model."""

import json
import re
import stat
from dataclasses import fields, is_dataclass
from inspect import get_annotations
from pathlib import Path
from typing import Any, cast

import yaml
from pydantic import BaseModel, ConfigDict, ValidationError
from pydantic.fields import FieldInfo

from repro.errors import InputError, failure, one_of

#: Largest YAML and JSON file, bytes. YAML is read at about 50 kB/s.
LARGEST_YAML, LARGEST_JSON = 256 << 10, 512 << 10
#: Most lists and sections within each other.
DEEPEST = 50
#: Most values of a YAML file with its aliases written out.
MOST_VALUES = 300_000
#: Most digits of an integer, so that it fits in 64 bits.
MOST_DIGITS = 18

_INTEGER = re.compile(rf"[-+]?(0|[1-9][0-9]{{0,{MOST_DIGITS - 1}}})")
#: What YAML 1.1, also as Snakemake reads it, takes for text: it wants a point and a sign.
_POWER_OF_TEN = re.compile(r"[-+]?[0-9]+(?:\.[0-9]*)?[eE][-+]?[0-9]{1,3}")
_DIGITS = f"{MOST_DIGITS} decimal digits at most"
_SURROGATE = re.compile("[\ud800-\udfff]")
_TOO_DEEP = ("lists within lists without end", f"at most {DEEPEST} within each other")


def read_bytes(path: Path, most: int, expected: str) -> bytes:
    """Content of a regular file of at most `most` bytes; a pipe or a device could be endless."""
    try:
        check_size(path, most, expected)
        with path.open("rb") as file:
            content = file.read(most + 1)  # files of /proc have no size
    except OSError as error:
        raise InputError.at(str(path), failure(error), expected) from error
    if len(content) > most:
        raise _too_large(path, len(content), most)
    return content


def check_size(path: Path, most: int, expected: str) -> int:
    """Size of a file; refuse what is not a regular file of at most `most` bytes."""
    status = path.stat()
    if stat.S_ISDIR(status.st_mode):
        raise InputError.at(str(path), "a folder", expected)
    if not stat.S_ISREG(status.st_mode):
        raise InputError.at(str(path), "a pipe or a device", expected)
    if status.st_size > most:
        raise _too_large(path, status.st_size, most)
    return status.st_size


def _too_large(path: Path, size: int, most: int) -> InputError:
    return InputError.at(f"{path}: size", f"{size} bytes or more", f"at most {most} bytes")


class Loader(yaml.SafeLoader):
    """YAML as plain data, with the limits of this module."""

    def __init__(self, text: str, name: str) -> None:
        super().__init__(text)
        self.name, self._left = name, MOST_VALUES
        self._fields: dict[int, str] = {}  # by the identity of a scalar's node

    def get_single_node(self) -> yaml.Node | None:
        """Build the tree of the document after checking its size with every alias written out."""
        node = super().get_single_node()
        self._count(node, DEEPEST)
        return node

    def _count(self, node: yaml.Node | None, levels: int, field: str = "") -> None:
        self._left -= 1
        if not levels and isinstance(node, yaml.CollectionNode):
            raise self._refused(node, *_TOO_DEEP)
        if self._left < 0:
            raise InputError.at(self.name, f"aliases that expand to more than {MOST_VALUES} values", "fewer")
        if isinstance(node, yaml.MappingNode):
            names: set[str] = set()
            for key, value in node.value:
                self._count(key, levels - 1)
                self._check_key(key, names)
                names.add(key.value)
                self._count(value, levels - 1, f"{field}.{key.value[:60]}" if field else key.value[:60])
        elif isinstance(node, yaml.SequenceNode):
            for number, item in enumerate(node.value):
                self._count(item, levels - 1, f"{field}[{number}]")
        elif isinstance(node, yaml.ScalarNode):
            self._fields[id(node)] = field
            if _SURROGATE.search(node.value):
                raise self._refused(node, ascii(node.value[:40]), "characters that UTF-8 can hold")

    def _check_key(self, key: yaml.Node, earlier: set[str]) -> None:
        if not isinstance(key, yaml.ScalarNode) or key.tag != "tag:yaml.org,2002:str":
            name = repr(key.value)[:60] if isinstance(key, yaml.ScalarNode) else "that is a list or a section"
            raise self._refused(key, f"the key {name}", "text as key")
        if not key.value.isprintable():
            raise self._refused(key, f"the key {key.value[:40]!a}", "a key without control characters")
        if key.value in earlier:
            raise self._refused(key, f"the key {key.value!r} twice", "each key once")

    def construct_yaml_int(self, node: yaml.ScalarNode) -> int:
        """Build an integer from decimal digits; YAML would read 1:30 as 90 and 010 as 8."""
        if not _INTEGER.fullmatch(node.value):
            raise self._refused(node, repr(node.value[:40]), f"an integer of {_DIGITS}, without a leading zero")
        return int(node.value)

    def construct_yaml_float(self, node: yaml.ScalarNode) -> float:
        """Build a number without a base of 60."""
        if ":" in node.value:
            raise self._refused(node, repr(node.value[:40]), "a decimal number")
        return super().construct_yaml_float(node)

    def _refused(self, node: yaml.Node, found: str, expected: str) -> InputError:
        field = self._fields.get(id(node))
        place = f"{self.name}: line {node.start_mark.line + 1}" + (f": {field}" if field else "")
        return InputError.at(place, found, expected)


for _tag, _construct in (("int", Loader.construct_yaml_int), ("float", Loader.construct_yaml_float)):
    Loader.add_constructor(f"tag:yaml.org,2002:{_tag}", _construct)


def read_yaml(path: Path, expected: str, loader: type[Loader] = Loader) -> dict[str, Any]:
    """Read sections of a YAML file; an empty file has none."""
    data = read_bytes(path, LARGEST_YAML, expected)
    try:
        # A subclass of SafeLoader makes no object but plain data.
        content = loader(data.decode("utf-8-sig"), str(path)).get_single_data()
    except InputError:
        raise
    except RecursionError as error:
        raise InputError.at(str(path), *_TOO_DEEP) from error
    except (yaml.YAMLError, ValueError, LookupError, TypeError, AttributeError) as error:  # of a tag that does not fit
        found = f"text that is not YAML ({' '.join(str(error).split())[:300]})"
        raise InputError.at(str(path), found, f"{expected} in YAML, each key once") from error
    if content is None:
        return {}
    if not isinstance(content, dict):
        raise InputError.at(str(path), repr(content)[:60], "keys with values, such as 'gravity: 9.81'")
    return content


def read_json(path: Path, most: int = LARGEST_JSON) -> object:
    """Read a JSON file of at most `most` bytes within the other limits of this module; see `parse_json`."""
    data = read_bytes(path, most, "a JSON file")
    try:
        return parse_json(data.decode("utf-8"), str(path))
    except InputError:
        raise
    except ValueError as error:
        raise InputError.at(str(path), f"text that is not JSON ({error})", "a JSON file") from error


def parse_json(text: str, place: str) -> object:
    """Content of JSON text."""

    def once(pairs: list[tuple[str, object]]) -> dict[str, object]:
        content = dict(pairs)
        if len(content) < len(pairs):
            keys = [key for key, _ in pairs]
            twice = next(key for key in content if keys.count(key) > 1)
            raise InputError.at(place, f"the key {twice[:40]!r} twice", "each key once")
        return content

    def integer(digits: str) -> int:
        if len(digits.lstrip("-")) > MOST_DIGITS:
            raise InputError.at(place, f"an integer of {len(digits)} digits", _DIGITS)
        return int(digits)

    def constant(name: str) -> None:
        raise ValueError(f"{name} is not a JSON number")

    try:
        content: object = json.loads(text, object_pairs_hook=once, parse_int=integer, parse_constant=constant)
        too_deep = _depth(content) > DEEPEST
    except RecursionError:
        too_deep = True
    if too_deep:
        raise InputError.at(place, *_TOO_DEEP)
    return content


def _depth(node: object) -> int:
    """Levels of lists and objects within each other."""
    inner = node.values() if isinstance(node, dict) else node if isinstance(node, list) else None
    return 0 if inner is None else 1 + max(map(_depth, inner), default=0)


#: Keys and list positions that lead to a value.
Place = tuple[str | int, ...]
#: Rules of what a file declares: no value is converted, no key is unknown.
STRICT = ConfigDict(
    extra="forbid", strict=True, allow_inf_nan=False, regex_engine="python-re", hide_input_in_errors=True
)
#: What a value should be, by the kind of pydantic's error; limits are filled in.
_EXPECTED = {
    "int_type": "an integer",
    "float_type": "a number",
    "string_type": "text",
    "string_unicode": "text in UTF-8",
    "bool_type": "true or false, a boolean",
    "list_type": "a list",
    "tuple_type": "a list",
    "dict_type": "a section",
    "dataclass_type": "a section",
    "model_type": "a section",
    "too_short": "at least {min_length} values",
    "too_long": "at most {max_length} values",
    "string_too_short": "at least {min_length} character",
    "string_too_long": "at most {max_length} characters",
    "string_pattern_mismatch": "a folder of the project, in letters, digits, '_', '.', '-' and '/'",
}
_LIMITS = {
    "greater_than": "more than {gt:.16g}",
    "greater_than_equal": "at least {ge:.16g}",
    "less_than": "less than {lt:.16g}",
    "less_than_equal": "at most {le:.16g}",
    "finite_number": "a finite number",
}


class Section(BaseModel):
    """A section of a file: no other key is allowed, no value is converted, a key without a default is required."""

    model_config = ConfigDict(**STRICT, frozen=True)


def spelled(place: Place) -> str:
    """``("numeric", "arms", "N1", 3)`` as ``numeric.arms.N1[3]``; a key of points alone in quotes."""

    def part(key: str | int) -> str:
        return f"[{key!r}]" if isinstance(key, int) or not key.strip(".") else f".{key}"

    return "".join(map(part, place)).removeprefix(".")


def violation(content: object, model: type[BaseModel]) -> tuple[Place, object, str] | None:
    """Place, found and expected of the first value that a model does not allow."""
    try:
        model.model_validate(content)
    except ValidationError as invalid:
        return first_error(invalid, model)
    return None


def first_error(invalid: ValidationError, section: Any) -> tuple[Place, object, str]:  # noqa: ANN401
    """Place, found and expected; what is expected is as the key's declaration states it, if it does."""
    error = invalid.errors(include_url=False)[0]
    place, kind, limits = error["loc"], error["type"], error.get("ctx", {})
    inner, stated = _along(section, place)
    found = repr(error["input"])[:60]
    match kind:
        case "extra_forbidden" | "unexpected_keyword_argument":
            found, expected = "an unknown key", one_of(_fields(inner), place[-1])
        case "literal_error" if place[-1] == "[key]":
            place, found, expected = place[:-1], "an unknown key", f"one of {limits['expected']}"
        case "literal_error":
            expected = limits["expected"]
        case "invalid_key":
            place, found, expected = place[:-1], f"the key {place[-1]!r}", "text"
        case "missing":  # an item of a pair, or a key
            found, expected = "nothing", stated if isinstance(place[-1], int) and stated else "a value"
        case _ if kind in _LIMITS:
            limit = _LIMITS[kind].format(**limits)
            expected = f"{stated} ({limit})" if stated else limit
        case _:
            expected = stated or _EXPECTED[kind].format(**limits) if kind in _EXPECTED else error["msg"]
            power = kind in ("int_type", "float_type") and _POWER_OF_TEN.fullmatch(str(error["input"]))
            if power and (kind == "float_type" or float(error["input"]).is_integer()):
                expected += f", written {float(error['input']):.{MOST_DIGITS - 1}g}"
    return place, found, expected


def _fields(section: Any) -> dict[str, FieldInfo]:  # noqa: ANN401
    """Keys of a model, of a dataclass or of a TypedDict that a file may have."""
    declared = getattr(section, "__pydantic_fields__", None)
    if declared is None:
        typed = {one.name: one.type for one in fields(section)} if is_dataclass(section) else get_annotations(section)
        return {name: FieldInfo.from_annotation(cast(Any, kind)) for name, kind in typed.items()}
    return {field.alias or name: field for name, field in declared.items() if not field.exclude}


def _along(section: Any, place: Place) -> tuple[Any, str]:  # noqa: ANN401
    """Innermost section on the way to a place, and what the innermost key on it states that it expects."""
    stated = ""
    for name in place:
        fields = _fields(section) if isinstance(section, type) else {}
        if name not in fields:
            break
        extra = fields[str(name)].json_schema_extra
        stated = str(extra.get("expected", "")) if isinstance(extra, dict) else ""
        section = fields[str(name)].annotation
    return section, stated
