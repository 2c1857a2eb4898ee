"""A bag of ROS as a table of joint states."""

import struct
from pathlib import Path
from typing import Any

from repro.documents import check_size
from repro.errors import InputError, require, shown
from repro.logs.plain_text import MAX_FILE_BYTES
from repro.logs.table import Table

MAX_MESSAGES = 200_000  # most messages, of which each takes some kilobytes of memory


def is_bag(path: Path) -> bool:
    """Whether a path is a file or the folder of a bag."""
    return path.suffix in (".mcap", ".db3", ".bag") or (path / "metadata.yaml").is_file()


def read_bag(path: Path, topic: str | None) -> Table:
    """Read the joint states of a bag: a row for each message, numbered from 1, time in s since the first stamp."""
    if not path.exists():
        raise InputError.at(str(path), "no such file", "a ROS 2 bag")
    files = sorted(file for file in path.iterdir() if not file.is_dir()) if path.is_dir() else [path]
    for file in files:
        check_size(file, MAX_FILE_BYTES, "a file of a ROS 2 bag")
    require("rosbags", "bags", str(path))
    import apsw  # noqa: PLC0415  (rosbags reads SQLite and Zstandard by these)
    from backports.zstd import ZstdError  # noqa: PLC0415
    from rosbags.highlevel import AnyReader, AnyReaderError  # noqa: PLC0415
    from rosbags.rosbag2 import ReaderError  # noqa: PLC0415
    from rosbags.typesys import Stores, TypesysError, get_typestore  # noqa: PLC0415

    named = (AnyReaderError, ReaderError, TypesysError, apsw.Error, ZstdError, OSError)
    # What parsing of damaged bytes raises in Python and in the library's own code.
    damage = (
        *(struct.error, ArithmeticError, AssertionError, AttributeError, LookupError, MemoryError),
        *(RuntimeError, TypeError, ValueError),
    )
    try:
        with AnyReader([path], default_typestore=get_typestore(Stores.LATEST)) as reader:
            topics = sorted({c.topic for c in reader.connections if c.msgtype == "sensor_msgs/msg/JointState"})
            chosen = [name for name in topics if topic in (None, name)]
            if len(chosen) != 1:
                expected = f"{topic or 'one, or the one to read'}, as topic in the arm file"
                raise InputError.at(f"{path}: topics of sensor_msgs/JointState", ", ".join(topics) or "none", expected)
            wanted = [c for c in reader.connections if c.topic == chosen[0]]
            if (n := sum(c.msgcount for c in wanted)) > MAX_MESSAGES:
                raise InputError.at(f"{path}: {chosen[0]}", f"{n} messages", f"at most {MAX_MESSAGES}")
            messages = [(at, reader.deserialize(raw, c.msgtype)) for c, at, raw in reader.messages(wanted)]
            return _table(path, chosen[0], messages)
    except InputError:
        raise
    except (*named, *damage) as error:
        said = " ".join(str(error).split())[:200] if isinstance(error, named) else ""
        found = said or "bytes that are no messages"
        raise InputError.at(str(path), found, "a whole bag of ROS") from error


def _table(path: Path, topic: str, messages: list[tuple[int, Any]]) -> Table:
    """Tabulate messages, each with the time at which it was received, ns."""
    if not messages:
        raise InputError.at(f"{path}: {topic}", "no messages", "joint states")
    notes = [f"{len(messages)} messages of {topic}, counted as lines"]
    stamps = [m.header.stamp.sec * 10**9 + m.header.stamp.nanosec for _, m in messages]
    if not any(stamps):
        notes.append("the messages have no stamps; the times at which they were received are taken")
        stamps = [at for at, _ in messages]
    rows: list[dict[str, str]] = []
    for stamp, (_, message) in zip(stamps, messages, strict=True):
        row = {"time": repr((stamp - stamps[0]) / 1e9)}
        for kind in ("position", "velocity", "effort"):
            values = getattr(message, kind)
            if len(values) not in (0, len(message.name)):
                found = f"{len(values)} values of {kind} for {len(message.name)} joints"
                raise InputError.at(f"{path}: {topic}: message {len(rows) + 1}", found, "one for each joint, or none")
            if len(values):
                row |= {f"{name}.{kind}": repr(float(x)) for name, x in zip(message.name, values, strict=True)}
        rows.append(row)
    header = tuple(dict.fromkeys(shown(name) for row in rows for name in row))
    rows = [{shown(name): value for name, value in row.items()} for row in rows]
    cells = [(number, [row.get(name, "") for name in header]) for number, row in enumerate(rows, 1)]
    return Table(str(path), header, lambda: [cells], tuple(notes))
