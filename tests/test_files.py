"""Result files are whole or absent, the same bytes every time, and errors are one line."""

import json
import os

import pandas as pd
import pytest
from experiment_example import refused

from repro.documents import read_json
from repro.errors import InputError
from repro.files import atomic_write, fill_folder, parse_rows, read_csv, read_rows, write_csv, write_json, write_text


class Interrupted(BaseException):
    """Stands for a signal that arrives in the middle of a write."""


@pytest.mark.parametrize("error", [RuntimeError, Interrupted])
@pytest.mark.parametrize("old", [None, b"old"])
def test_a_writer_that_fails_leaves_the_folder_as_it_was(tmp_path, error, old):
    target = tmp_path / "table.csv"
    if old is not None:
        target.write_bytes(old)

    def half(temporary):
        temporary.write_bytes(b"half a fi")
        raise error("disk full")

    with pytest.raises(error, match="disk full"):
        atomic_write(target, half)
    left = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    assert left == ({} if old is None else {"table.csv": old})


def test_a_target_that_cannot_be_replaced_leaves_no_temporary_file(tmp_path):
    target = tmp_path / "taken"
    target.mkdir()
    with pytest.raises(OSError, match="taken"):
        write_text(target, "text")
    assert list(tmp_path.iterdir()) == [target]


@pytest.mark.parametrize("name", ["parameters.csv", "runs.csv"])
def test_no_input_is_replaced_or_removed_with_files_of_another_run(tmp_path, name):
    (tmp_path / name).write_text("my log")
    (tmp_path / "arm.urdf").write_text("of another run")

    def fill(folder):
        (folder / "parameters.csv").write_text("new")

    with pytest.raises(InputError, match="an input of this command"):
        fill_folder(tmp_path, fill, optional=("runs.csv", "arm.urdf"), inputs=[tmp_path / name])
    assert sorted(path.name for path in tmp_path.iterdir()) == ["arm.urdf", name]
    assert (tmp_path / name).read_text() == "my log"
    fill_folder(tmp_path, fill, optional=("runs.csv", "arm.urdf"))
    assert [(path.name, path.read_text()) for path in tmp_path.iterdir()] == [("parameters.csv", "new")]


@pytest.mark.parametrize(("umask", "mode"), [(0o022, 0o644), (0o077, 0o600)])
def test_files_get_the_usual_permissions(tmp_path, umask, mode):
    before = os.umask(umask)
    try:
        write_text(tmp_path / "shared.txt", "text")
        assert os.umask(umask) == umask  # left as it was
    finally:
        os.umask(before)
    assert (tmp_path / "shared.txt").stat().st_mode & 0o777 == mode


def test_json_bytes_depend_on_the_content_alone(tmp_path):
    one, two = tmp_path / "one.json", tmp_path / "two.json"
    write_json(one, {"b": [1, 0.1], "a": {"y": None, "x": "τ"}})
    write_json(two, {"a": {"x": "τ", "y": None}, "b": [1, 0.1]})
    assert one.read_bytes() == two.read_bytes()
    assert one.read_bytes().endswith(b"}\n")
    assert read_json(one) == {"a": {"x": "τ", "y": None}, "b": [1, 0.1]}
    assert list(json.loads(one.read_text())) == ["a", "b"]


@pytest.mark.parametrize("bad", [float("nan"), float("inf"), -float("inf")])
def test_json_refuses_what_json_cannot_hold(tmp_path, bad):
    target = tmp_path / "result.json"
    write_json(target, {"total": 0.5})
    with pytest.raises(ValueError, match="JSON compliant"):
        write_json(target, {"total": bad})
    assert read_json(target) == {"total": 0.5}
    assert list(tmp_path.iterdir()) == [target]


def test_csv_text_is_fixed(tmp_path):
    frame = pd.DataFrame({"case": ["N1", "N2"], "joint": [1, 2], "total": [1 / 3, 1e-20], "sd": [0.5, 123456789.125]})
    write_csv(tmp_path / "t.csv", frame)
    expected = b"case,joint,total,sd\nN1,1,0.3333333333,0.5\nN2,2,1e-20,123456789.1\n"
    assert (tmp_path / "t.csv").read_bytes() == expected


@pytest.mark.parametrize(
    ("read", "content"),
    [
        (read_json, None),
        (read_json, b""),
        (read_json, b'{"a": 1'),
        (read_json, b"\xff\xfe"),
        (read_json, b'{"a": NaN}'),
        (read_csv, None),
        (read_csv, b""),
        (read_csv, b"a,b\n1,2\n1,2,3\n"),
        (read_csv, b'a,b\n"1,2\n'),
        (read_csv, b"\xff\xfe\x00a"),
    ],
)
def test_an_unreadable_file_gives_one_line(tmp_path, read, content):
    path = tmp_path / "run"
    if content is not None:
        path.write_bytes(content)
    assert refused(read, path).place.startswith(str(path))


def test_missing_columns_are_named(tmp_path):
    path = tmp_path / "t.csv"
    path.write_text("case,total\nN1,0.9\n")
    error = refused(read_csv, path, ("case", "joint", "total", "seeds"))
    assert error.place == f"{path}: header" and "joint, seeds" in error.found
    assert list(read_csv(path, ("case", "total")).columns) == ["case", "total"]


def test_a_byte_order_mark_is_no_part_of_the_first_column(tmp_path):
    path = tmp_path / "table.csv"
    path.write_bytes("\ufeffa,b\r\n1,2.5\r\n".encode())
    assert read_csv(path, ("a", "b")).to_dict("list") == {"a": [1], "b": [2.5]}
    assert read_rows(path, ("a", "b")) == [{"a": "1", "b": "2.5"}]
    assert refused(parse_rows, "a,b\n\n1,2\n3\n", "t.csv").place == "t.csv: line 4"
