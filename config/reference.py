"""Write the JSON schema and the tables of `config/README.md` from the model: ``python config/reference.py``."""

import re
from pathlib import Path
from typing import Any

import yaml

from repro.config.model import Configuration
from repro.files import write_text

ROOT = Path(__file__).resolve().parent.parent
README, SCHEMA = ROOT / "config/README.md", ROOT / "workflow/schemas/config.schema.yaml"
#: Longest default that a table shows.
SHORT = 60
#: Upper limits that only catch a misplaced digit.
FAR = (10_000_000, 1_000_000_000)


def schema_text() -> str:
    """JSON schema of a configuration, as YAML."""
    schema = {"$schema": "https://json-schema.org/draft/2020-12/schema", **_untitled(Configuration.model_json_schema())}
    text = yaml.safe_dump(schema, sort_keys=False, width=1000, default_flow_style=None)
    return "# Written by config/reference.py.\n" + text


def _untitled(schema: dict[str, Any]) -> dict[str, Any]:
    """Leave out the titles, which repeat the names."""
    nested = {name: _untitled(value) if isinstance(value, dict) else value for name, value in schema.items()}
    return {name: value for name, value in nested.items() if name != "title" or isinstance(value, dict)}


def readme_text(text: str) -> str:
    """The page with its tables, each below a comment that names its section, written again."""
    schema, values = Configuration.model_json_schema(), yaml.compose((ROOT / "config/config.yaml").read_text("utf-8"))
    sections = re.compile(r"(?<=<!-- keys of )([\w.]+)( -->\n)(?:\|.*\n)*")
    return sections.sub(lambda found: found[1] + found[2] + _table(schema, values, found[1].split(".")), text)


def _table(schema: dict[str, Any], values: yaml.Node, place: list[str]) -> str:
    section = schema
    for name in place if place != ["configuration"] else []:
        section = schema["$defs"][section["properties"][name]["$ref"].rpartition("/")[2]]
        values = _entry(values, name)
    keys = {name: key for name, key in section["properties"].items() if "description" in key}
    extra = [name for name in ("unit", "from") if any(name in key for key in keys.values())]
    header = ["key", "meaning", *extra, "default", "allowed"] if place != ["networks"] else ["key", "meaning", *extra]
    rows = [header, ["---"] * len(header)]
    for name, key in keys.items():
        cells = {"key": f"`{name}`", "meaning": key["description"], "unit": key.get("unit"), "from": key.get("from")}
        if "default" in header:
            cells |= {"default": _default(_entry(values, name), key), "allowed": _allowed(key)}
        rows.append([str(cells[column] or "-").replace("|", "\\|") for column in header])
    return "".join(f"| {' | '.join(row)} |\n" for row in rows)


def _entry(mapping: yaml.Node, name: str) -> yaml.Node | None:
    return next((value for key, value in mapping.value if key.value == name), None)


def _default(node: yaml.Node | None, key: dict[str, Any]) -> str:
    """Value as `config.yaml` spells it, or of a key that it leaves out that of the class."""
    if node is None:
        return f"`{key['default']}`"
    if isinstance(node, yaml.ScalarNode):
        return f"`{node.value}`"
    shown = f"[{', '.join(item.value for item in node.value)}]" if isinstance(node, yaml.SequenceNode) else ""
    return f"`{shown}`" if 0 < len(shown) <= SHORT else "[in the file](config.yaml)"


def _allowed(key: dict[str, Any]) -> str:
    """What the type of a key allows, and what is required beyond it."""
    kind, own = key.get("type"), key.get("allowed", "")
    if "enum" in key:
        words = ", ".join(f"`{value}`" for value in key["enum"])
    elif kind == "array":
        low, high = key["minItems"], key.get("maxItems")
        count = f"{low} values" if low == high else f"{low} to {high} values" if high else f"{low} or more values"
        words = f"{count}, each {_allowed(key['items'] if 'items' in key else key['prefixItems'][0])}"
    elif kind in ("number", "integer"):
        words = _range(key)
    else:
        words = {"boolean": "`true`, `false`", "string": "text"}.get(str(kind), "")
        words = "a path inside the project" if "pattern" in key else words
    return ", ".join(filter(None, (words, own)))


def _range(key: dict[str, Any]) -> str:
    """Limits of a number; those far beyond any use are left out."""
    above, least, below, most = (
        key.get(name) for name in ("exclusiveMinimum", "minimum", "exclusiveMaximum", "maximum")
    )
    low = f"above {above}" if above is not None else f"{least}"
    if below is not None:
        return f"{low}, below {below}"
    if most is None or most in FAR:
        return low if above is not None else f"{low} or more"
    return f"{least}" if least == most else f"{least} to {most}" if above is None else f"{low}, at most {most}"


def main() -> None:
    """Write both files."""
    write_text(SCHEMA, schema_text())
    write_text(README, readme_text(README.read_text("utf-8")))


if __name__ == "__main__":
    main()
