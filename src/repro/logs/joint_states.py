"""Joint states of a bag of ROS as an array, read in this process: a program that limits its own memory and time."""

import errno
import gc
import json
import resource
import sys
from pathlib import Path
from typing import Any

import numpy as np

from repro.errors import InputError, shown

MAX_MESSAGES, MAX_COLUMNS = 200_000, 1000  # most messages, and most columns of their table
_MAX_VALUES = 20_000_000  # most numbers of the table
_MAX_MEMORY_BYTES, _MAX_UNPACKED_FILE_BYTES = 1 << 30, 512 << 20  # address space; size of a file that is unpacked
_MAX_SECONDS = 7  # computing time, to which each so many messages add a second:
_MESSAGES_PER_SECOND = 5_000  # a third of what was measured
_EXPECTED = "a whole bag of ROS"
_TOO_LARGE = "contents that unpack to more than is read", "a smaller bag, of joint states alone"
#: What the library says of damaged bytes, and what it is; the first that fits.
_DAMAGE = {
    "not indexed": "no index of the messages (rosbag reindex writes it)",
    "ompression": "a compression that is not supported",
    "version": "a version of the format that is not supported",
    "ncryption": "an encrypted bag",
    "storage plugin": "a storage that is not supported",
    "missing": "a file or a table of the bag missing",
    "etadata": "metadata that are not those of a bag",
    "hash mismatch": "messages of another definition",
    "empty": "an empty file",
    "magic": "another format than its name states",
    "timestamp order": "messages that are neither indexed nor in the order of time",
}


def read_joint_states(path: Path, topic: str | None) -> dict[str, Any]:
    """Read header, values (messages, columns) and notes of a topic; NaN where a message has no value."""
    try:
        return _read(path, topic)
    except InputError:
        raise
    except MemoryError as error:
        raise InputError.at(str(path), *_TOO_LARGE) from error
    # Damaged bytes, which the library reads unchecked, raise errors of Python, SQLite, YAML and decompressors.
    except Exception as error:
        no_memory = "emory" in str(error) or "resize buffer" in str(error)  # SQLite; LZ4
        too_large = no_memory or (isinstance(error, OSError) and error.errno == errno.EFBIG)
        refusal = _TOO_LARGE if too_large else (_found(error), _EXPECTED)
        raise InputError.at(str(path), *refusal) from error


def _read(path: Path, topic: str | None) -> dict[str, Any]:
    from rosbags.highlevel import AnyReader  # noqa: PLC0415
    from rosbags.typesys import Stores, get_typestore  # noqa: PLC0415

    with AnyReader([path], default_typestore=get_typestore(Stores.LATEST)) as reader:
        storages = [getattr(each, "storage", None) for each in reader.readers]  # of a folder, those of its files
        named = max(len(getattr(storage, "storages", ())) for storage in storages)
        if path.is_dir() and named > sum(1 for _ in path.iterdir()):
            raise InputError.at(f"{path / 'metadata.yaml'}: relative_file_paths", f"{named} files", "each file once")
        topics = sorted({str(c.topic) for c in reader.connections if c.msgtype == "sensor_msgs/msg/JointState"})
        chosen = [name for name in topics if topic in (None, name)]
        if len(chosen) != 1:
            expected = f"{topic or 'one, or the one to read'}, as topic in the arm file"
            listed = ", ".join(topics[:20]) + " and more" * (len(topics) > 20)
            raise InputError.at(f"{path}: topics of sensor_msgs/JointState", listed or "none", expected)
        wanted = [c for c in reader.connections if c.topic == chosen[0]]
        place, rows = f"{path}: {chosen[0]}", _Rows(f"{path}: {chosen[0]}")
        if (n := sum(c.msgcount for c in wanted)) > MAX_MESSAGES:
            raise InputError.at(place, f"{n} messages", f"at most {MAX_MESSAGES}")
        for connection, received, raw in reader.messages(wanted):
            rows.add(received, reader.deserialize(raw, connection.msgtype))
            if len(rows.rows) % _MESSAGES_PER_SECOND == 0:
                _add_a_second()
    return rows.table(chosen[0])


class _Rows:
    """Numbers of messages, by the columns of their table."""

    def __init__(self, place: str) -> None:
        self.place, self.columns = place, {"time": 0}
        self.stamps, self.received, self.rows = list[int](), list[int](), list[Any]()
        self._places: dict[tuple[tuple[str, ...], str], Any] = {}

    def add(self, received: int, message: Any) -> None:  # noqa: ANN401  (of a class that the library makes)
        """Add a row."""
        if len(self.rows) == MAX_MESSAGES:
            raise InputError.at(self.place, f"more than {MAX_MESSAGES} messages", f"at most {MAX_MESSAGES}")
        self.stamps.append(message.header.stamp.sec * 10**9 + message.header.stamp.nanosec)
        self.received.append(received)
        names, parts = tuple(message.name), []
        for kind in ("position", "velocity", "effort"):
            values = np.array(getattr(message, kind), dtype=np.float64)
            if len(values) not in (0, len(names)):
                found, place = f"{len(values)} values of {kind} for {len(names)} joints", len(self.rows) + 1
                raise InputError.at(f"{self.place}: message {place}", found, "one for each joint, or none")
            if len(values):
                parts.append((self._columns(names, kind), values))
        self.rows.append(parts)

    def _columns(self, names: tuple[str, ...], kind: str) -> Any:  # noqa: ANN401
        """Find the columns of a kind of value, or add them."""
        if (names, kind) not in self._places:
            headers = [shown(f"{name}.{kind}") for name in names]
            for header in headers:
                self.columns.setdefault(header, len(self.columns))
            if len(self.columns) > MAX_COLUMNS:
                raise InputError.at(self.place, f"{len(self.columns)} columns", f"at most {MAX_COLUMNS}")
            self._places[names, kind] = np.array([self.columns[header] for header in headers])
        return self._places[names, kind]

    def table(self, topic: str) -> dict[str, Any]:
        """Build the table, with time in s since the first message."""
        n = len(self.rows)
        if not n:
            raise InputError.at(self.place, "no messages", "joint states")
        if n * len(self.columns) > _MAX_VALUES:
            raise InputError.at(self.place, f"{n * len(self.columns)} numbers", f"at most {_MAX_VALUES}")
        notes, stamps = [f"{n} messages of {shown(topic)}, counted as lines"], self.stamps
        if not any(stamps):
            notes.append("the messages have no stamps; the times at which they were received are taken")
            stamps = self.received
        values = np.full((n, len(self.columns)), np.nan)
        values[:, 0] = [(stamp - stamps[0]) / 1e9 for stamp in stamps]
        for row, parts in zip(values, self.rows, strict=True):
            for columns, numbers in parts:
                row[columns] = numbers
        return {"header": list(self.columns), "notes": notes, "values": values}


def _found(error: Exception) -> str:
    """Name the damage in our words, if the library itself names it."""
    ours = type(error).__name__ in ("AnyReaderError", "ReaderError") or isinstance(error, FileNotFoundError)
    named = (words for part, words in _DAMAGE.items() if ours and part in str(error))
    return next(named, "bytes that are no messages")


def limit() -> None:
    """Limit memory, computing time and unpacked files of this process: libraries unpack without a limit."""
    limits = {
        resource.RLIMIT_AS: _MAX_MEMORY_BYTES,
        resource.RLIMIT_FSIZE: _MAX_UNPACKED_FILE_BYTES,
        resource.RLIMIT_CORE: 0,
        resource.RLIMIT_CPU: _MAX_SECONDS,
    }
    for kind, most in limits.items():
        _set_limit(kind, most)


def _set_limit(kind: int, most: int) -> None:
    hard = resource.getrlimit(kind)[1]
    resource.setrlimit(kind, (most if hard == resource.RLIM_INFINITY else min(most, hard), hard))


def _add_a_second() -> None:
    """Allow a second more of computing time, if it is limited."""
    soft, _ = resource.getrlimit(resource.RLIMIT_CPU)
    if soft != resource.RLIM_INFINITY:
        _set_limit(resource.RLIMIT_CPU, soft + 1)


def main(file: str, topic: str | None = None) -> int:
    """Write the arrays to standard output, or the parts of an error to standard error."""
    limit()
    gc.disable()  # the rows of a bag are many objects without cycles: searching them takes a fifth of the time
    try:
        np.savez(sys.stdout.buffer, **read_joint_states(Path(file), topic))
    except InputError as error:
        print(json.dumps([error.place, error.found, error.expected]), file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
