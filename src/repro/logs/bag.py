"""A ROS 2 bag as a table: the joint states of one topic, columns NAME.position, NAME.velocity and NAME.effort."""

from pathlib import Path
from typing import Any

from repro.documents import check_size
from repro.errors import InputError
from repro.logs.table import LARGEST, Table

#: Most messages, of which each takes some kilobytes of memory.
MOST_MESSAGES = 200_000
_TYPE = "sensor_msgs/msg/JointState"
_KINDS = ("position", "velocity", "effort")


def is_bag(path: Path) -> bool:
    """Whether a path is a file or the folder of a bag."""
    return path.suffix in (".mcap", ".db3") or (path / "metadata.yaml").is_file()


def read_bag(path: Path, topic: str | None) -> Table:
    """Read the joint states of a bag: a row for each message, numbered from 1, time in s since the first stamp."""
    if not path.exists():
        raise InputError.at(str(path), "no such file", "a ROS 2 bag")
    files = sorted(file for file in path.iterdir() if not file.is_dir()) if path.is_dir() else [path]
    for file in files:
        check_size(file, LARGEST, "a file of a ROS 2 bag")
    try:
        from rosbags.highlevel import AnyReader  # noqa: PLC0415
        from rosbags.typesys import Stores, get_typestore  # noqa: PLC0415
    except ImportError as error:
        expected = "the extra bags: python -m pip install --no-build-isolation --editable '.[bags]'"
        raise InputError.at(str(path), "a bag, and no package rosbags to read it", expected) from error
    try:
        with AnyReader([path], default_typestore=get_typestore(Stores.LATEST)) as reader:
            topics = sorted({c.topic for c in reader.connections if c.msgtype == _TYPE})
            chosen = [name for name in topics if topic in (None, name)]
            if len(chosen) != 1:
                expected = f"{topic or 'one, or the one to read'}, as topic in the arm file"
                raise InputError.at(f"{path}: topics of sensor_msgs/JointState", ", ".join(topics) or "none", expected)
            wanted = [c for c in reader.connections if c.topic == chosen[0]]
            if (n := sum(c.msgcount for c in wanted)) > MOST_MESSAGES:
                raise InputError.at(f"{path}: {chosen[0]}", f"{n} messages", f"at most {MOST_MESSAGES}")
            messages = [(at, reader.deserialize(raw, c.msgtype)) for c, at, raw in reader.messages(wanted)]
            return _table(path, chosen[0], messages)
    except InputError:
        raise
    except Exception as error:  # a damaged bag: the library has no error of its own for all that can be wrong
        found = " ".join(str(error).split())[:200] or type(error).__name__
        raise InputError.at(str(path), found, "a whole ROS 2 bag") from error


def _table(path: Path, topic: str, messages: list[tuple[int, Any]]) -> Table:
    """Tabulate messages, each with the time at which it was received, ns."""
    if not messages:
        raise InputError.at(f"{path}: {topic}", "no messages", "joint states")
    notes = [f"{len(messages)} messages of {topic}, counted as lines"]
    stamps = [m.header.stamp.sec * 10**9 + m.header.stamp.nanosec for _, m in messages]
    if not any(stamps):
        notes.append("the messages have no stamps; the times at which they were received are taken")
        stamps = [at for at, _ in messages]
    rows = []
    for stamp, (_, message) in zip(stamps, messages, strict=True):
        row = {"time": repr((stamp - stamps[0]) / 1e9)}
        for kind in _KINDS:
            if len(values := getattr(message, kind)):
                row |= {f"{name}.{kind}": repr(float(x)) for name, x in zip(message.name, values, strict=True)}
        rows.append(row)
    header = tuple(dict.fromkeys(name for row in rows for name in row))
    cells = [(number, [row.get(name, "") for name in header]) for number, row in enumerate(rows, 1)]
    return Table(str(path), header, lambda: [cells], len(cells), tuple(notes))
