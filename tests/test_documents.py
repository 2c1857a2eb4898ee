"""Files in YAML and JSON that exceed a limit or are ambiguous are refused in one line, quickly."""

import os
import time
from pathlib import Path

import pytest
from experiment_example import refused

from repro.documents import DEEPEST, LARGEST_JSON, LARGEST_YAML, read_bytes, read_json, read_yaml

BOMB = "a0: &a0 [x, x, x, x, x, x, x, x, x]\n"
BOMB += "".join(f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 9)}]\n" for k in range(1, 10))

#: Text, place in the file, what was found.
YAML = {
    "alias bomb": (f"zero: [1]\n{BOMB}", "", "aliases"),
    "alias to itself": ("zero: &z [*z]\n", "line 1", "lists within lists"),
    "key twice": ("a: 1\nb: {c: 1,\n c: 2}\n", "line 3", "'c'"),
    "key twice in a list": ("- {q1: 1, q1: 2}\n", "line 1", "'q1'"),
    "number as key": ("training: {1: 2}\n", "line 1", "'1'"),
    "nothing as key": ("training: {~: 2}\n", "line 1", "'~'"),
    "list as key": ("\n? [a, b]\n: 2\n", "line 2", "list"),
    "400 digits": ("a: 2\nsteps: 1" + "0" * 399, "line 2: steps", "'1000"),
    "5000 digits": ("steps: 1" + "0" * 4999, "line 1: steps", "'1000"),
    "base of 60": ("steps: 1:30\n", "line 1: steps", "'1:30'"),
    "part of base of 60": ("a: 2\nb: [{c: 1, d: [2, 1:30.5]}]\n", "line 2: b[0].d[1]", "'1:30.5'"),
    "octal": ("training:\n  steps: 010\n", "line 2: training.steps", "'010'"),
    "bad date": ("steps: 2020-99-99\n", None, "month"),
    "deep": ("a: " + "[" * 20000, "", "lists within lists"),
    "deep sections": ("".join(f"{' ' * k}a:\n" for k in range(DEEPEST + 1)), None, "lists within lists"),
    "python object": ("a: !!python/name:os.system\n", None, "python/name"),
    **{x: (f"a: !!{x}\n", None, "not YAML") for x in ("bool x", 'float ""', "int [1]", "timestamp x")},
    "two documents": ("a: 1\n---\na: 2\n", None, "document"),
    "scalar": ("steps", None, "'steps'"),
    "unknown anchor": ("a: *b\n", None, "undefined alias"),
    "tab": ("a:\n\tb: 1\n", None, "not YAML"),
    "control character": ("a: \0", None, "not YAML"),
    "large": ("a: " + "x" * LARGEST_YAML, "size", str(LARGEST_YAML + 3)),
}
JSON = {
    "key twice": ('{"a": 1, "b": {"c": 1, "c": 2}}', "'c'"),
    "400 digits": ('{"a": 1' + "0" * 399 + "}", "400 digits"),
    "5000 digits": ('{"a": -1' + "0" * 4999 + "}", "5001 digits"),
    "deep": ("[" * 100_000, "lists within lists"),
    "deep and closed": ("[" * (DEEPEST + 1) + "]" * (DEEPEST + 1), "lists within lists"),
    "large": ('"' + "x" * LARGEST_JSON + '"', str(LARGEST_JSON + 2)),
}


def refusal(read, path):
    began = time.process_time()
    error = refused(read, path)
    assert time.process_time() - began < 5.0
    assert error.place.startswith(str(path)) and len(str(error)) < 600
    return error.place.removeprefix(str(path)).strip(": "), f"{error.found}, {error.expected}"


@pytest.mark.parametrize(("text", "place", "found"), YAML.values(), ids=YAML)
def test_yaml_beyond_a_limit_is_refused(tmp_path, text, place, found):
    path = tmp_path / "arm.yaml"
    path.write_text(text)
    where, rest = refusal(lambda p: read_yaml(p, "an arm file"), path)
    assert place is None or where == place
    assert found in rest


@pytest.mark.parametrize(("text", "found"), JSON.values(), ids=JSON)
def test_json_beyond_a_limit_is_refused(tmp_path, text, found):
    path = tmp_path / "run.json"
    path.write_text(text)
    assert found in refusal(read_json, path)[1]


def test_what_is_within_the_limits_is_read(tmp_path):
    path = tmp_path / "a.yaml"
    path.write_text("a: [1, -20, 3.5, 1_000.5, true, ~]\nb: {c: text, d: {}}\n")
    assert read_yaml(path, "a file") == {"a": [1, -20, 3.5, 1000.5, True, None], "b": {"c": "text", "d": {}}}
    path.write_text("position_limit: &r [[-1, 1], &s [-2, 2]]\nworkspace: [*s, *s]\nlast: *r\n")
    content = read_yaml(path, "a file")
    assert (content["workspace"], content["last"]) == ([[-2, 2], [-2, 2]], [[-1, 1], [-2, 2]])
    path.write_text("")
    assert read_yaml(path, "a file") == {}
    path.write_text('"' + "x" * (LARGEST_JSON - 2) + '"')
    assert len(read_json(path)) == LARGEST_JSON - 2
    path.write_text("-" + "9" * 18)
    assert read_json(path) == 1 - 10**18
    path.write_text("[" * DEEPEST + "]" * DEEPEST)
    assert str(read_json(path)).count("[") == DEEPEST


def test_a_pipe_a_device_and_a_folder_are_refused_at_once(tmp_path):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    for path in (pipe, tmp_path):
        for read in (read_json, lambda p: read_yaml(p, "an arm file"), lambda p: read_bytes(p, 10, "a file")):
            refusal(read, path)
    assert refused(read_bytes, Path("/dev/zero"), 10, "a file").place == "/dev/zero"
