"""Bags of ROS: joint states read as the same numbers in a CSV file do."""

import sqlite3
import struct
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from backports.zstd import ZstdCompressor
from experiment_example import refused
from hypothesis import given, settings
from log_example import RATE, assert_same, columns, recording, text
from lz4.frame import LZ4FrameCompressor
from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore
from strategies import seeds

from repro.errors import InputError
from repro.identification.armfile import Arm
from repro.logs.joint_states import read_joint_states
from repro.logs.load import read_log

GOOD = recording(np.arange(600) / RATE)
START = 1_700_000_000_123_456_789
STORE = get_typestore(Stores.ROS2_HUMBLE)
TYPES = ("sensor_msgs/msg/JointState", "std_msgs/msg/Header", "builtin_interfaces/msg/Time")
JointState, Header, Time = (STORE.types[name] for name in TYPES)


def states(r=GOOD, names=("joint1", "joint2"), velocity=True, stamped=True, start=START):
    """Messages of a recording, each with the time at which it is received, ns."""
    for k, t in enumerate(r.t):
        at = start + round(1e9 * t)
        stamp = Time(*divmod(at, 10**9)) if stamped else Time(0, 0)
        dq = r.dq[:, k].copy() if velocity else np.zeros(0)
        joints = JointState(Header(stamp, ""), list(names), r.q[:, k].copy(), dq, r.tau[:, k].copy())
        yield at + (250_000_000 if stamped else 0), joints  # received late


def write(folder, topics, storage="MCAP"):
    with Writer(folder, version=9, storage_plugin=StoragePlugin[storage]) as writer:
        for topic, messages in topics.items():
            to = writer.add_connection(topic, JointState.__msgtype__, typestore=STORE)
            for at, message in messages:
                writer.write(to, at, STORE.serialize_cdr(message, JointState.__msgtype__))
    return folder


def refusal(path, **arm):
    return refused(read_log, path, Arm(**arm))


@pytest.mark.parametrize("storage", ["MCAP", "SQLITE3"])
@pytest.mark.parametrize("velocity", [True, False])
def test_a_bag_and_a_table_of_the_same_numbers_are_the_same_log(tmp_path, storage, velocity):
    folder = write(tmp_path / "arm", {"/joint_states": states(velocity=velocity)}, storage)
    table = {name: values for name, values in columns(GOOD).items() if velocity or not name.startswith("d")}
    (tmp_path / "log.csv").write_text(text(table, 17))
    plain = read_log(tmp_path / "log.csv", Arm())
    (file,) = (path for path in folder.iterdir() if path.suffix != ".yaml")
    for path in (folder, file):
        log = read_log(path, Arm())
        assert log.name == path.name
        np.testing.assert_allclose(log.t, plain.t, atol=1e-12)
        for one, other in ((log.q, plain.q), (log.tau, plain.tau), (log.dq, plain.dq)):
            np.testing.assert_array_equal(one, other)
        assert {"600", "/joint_states,"} <= set(log.notes[0].split())


def test_a_bag_of_a_recorder_that_kept_no_definitions(tmp_path):
    folder = write(tmp_path / "arm", {"/joint_states": states()}, "SQLITE3")
    with sqlite3.connect(folder / "arm.db3") as database:
        database.execute("DELETE FROM message_definitions")
    database.close()
    assert_same(read_log(folder, Arm()), GOOD)


def test_the_stamps_of_simulated_time_begin_at_zero(tmp_path):
    late = ((at + k * 10**6, message) for k, (at, message) in enumerate(states(start=0)))
    assert_same(read_log(write(tmp_path / "arm", {"/joint_states": late}), Arm()), GOOD)


def test_messages_without_stamps_and_of_other_joints(tmp_path):
    gripper = states(recording(GOOD.t + 1e-3), ("finger", "thumb"), stamped=False)
    mixed = sorted([*states(stamped=False), *gripper], key=lambda pair: pair[0])
    log = read_log(write(tmp_path / "arm", {"/joint_states": mixed}), Arm())
    assert_same(log, GOOD)
    assert any(note.startswith("600 ") for note in log.notes)
    assert any("finger.position" in note for note in log.notes)


def test_the_arm_file_names_joints_of_any_name_and_one_of_two_topics(tmp_path):
    path = write(tmp_path / "named", {"/joint_states": states(names=("a", "b"))})
    assert "time, a.position, b.position, a.velocity" in refusal(path).found
    named = {"q1": "a.position", "q2": "b.position", "tau1": "a.effort", "tau2": "b.effort"}
    assert_same(replace(read_log(path, Arm(columns=named)), dq=None), GOOD)
    path = write(tmp_path / "arm", {"/b": states(), "/a": states(recording(GOOD.t + 1.0))})
    for topic in (None, "/c"):
        error = refusal(path, topic=topic)
        assert (error.place, error.found) == (f"{path}: topics of sensor_msgs/JointState", "/a, /b")
    assert_same(read_log(path, Arm(topic="/b")), GOOD)


@pytest.mark.parametrize("text", ["\x1b[31m", "a\r\nb", "\x9b2J", "\u202e"])
def test_names_in_a_bag_reach_no_page_as_they_are(tmp_path, text):
    names = {"q1": f"a{text}.position", "q2": "b.position", "tau1": f"a{text}.effort", "tau2": "b.effort"}
    folder = write(tmp_path / "arm", {f"/{text}": states(names=(f"a{text}", "b"))}, "SQLITE3")
    assert str(refusal(folder)).isprintable()
    log = read_log(folder, Arm(columns={signal: ascii(name)[1:-1] for signal, name in names.items()}))
    np.testing.assert_array_equal(log.q, GOOD.q)
    assert all(note.isprintable() for note in log.notes)
    assert any(ascii(text)[1:-1] in note for note in log.notes)


def test_a_bag_that_names_a_file_many_times_is_refused(tmp_path):
    folder = write(tmp_path / "arm", {"/joint_states": states()}, "SQLITE3")
    metadata = folder / "metadata.yaml"
    lines = metadata.read_text().splitlines()
    place = lines.index("  relative_file_paths:") + 1
    metadata.write_text("\n".join([*lines[:place], *lines[place : place + 1] * 9, *lines[place + 1 :]]))
    error = refusal(folder)
    assert (error.place, error.found) == (f"{metadata}: relative_file_paths", "9 files")


def test_metadata_that_take_long_to_read_end_in_time(tmp_path):
    folder = write(tmp_path / "arm", {"/joint_states": states()})
    with (folder / "metadata.yaml").open("a") as file:
        file.writelines(f"k{number}: [1, 2, 3]\n" for number in range(300_000))
    run = subprocess.run([sys.executable, "-c", MEASURED, folder], capture_output=True, text=True, check=True)
    found, _, seconds = run.stdout.splitlines()
    assert found == "contents that take too long to read"
    assert float(seconds) < 10


def test_bags_that_cannot_be_read(tmp_path, monkeypatch):
    assert refusal(tmp_path / "none.mcap").place == str(tmp_path / "none.mcap")
    assert refusal(write(tmp_path / "empty", {})).found == "none"
    assert refusal(write(tmp_path / "silent", {"/joint_states": ()})).place.endswith(": /joint_states")
    whole = (write(tmp_path / "arm", {"/joint_states": states()}) / "arm.mcap").read_bytes()
    for content in (b"", b"no bag", whole[: len(whole) // 2]):
        (tmp_path / "bad.mcap").write_bytes(content)
        assert refusal(tmp_path / "bad.mcap").place == str(tmp_path / "bad.mcap")
    monkeypatch.setattr("repro.logs.joint_states.MAX_MESSAGES", 599)
    error = refused(read_joint_states, tmp_path / "arm", None)
    assert (error.place, error.found) == (f"{tmp_path / 'arm'}: /joint_states", "600 messages")
    (tmp_path / "metadata.yaml").write_text("- nothing\n")
    assert refusal(tmp_path).place.startswith(str(tmp_path))
    monkeypatch.setattr("repro.errors.find_spec", lambda package: None)
    assert refusal(tmp_path / "bad.mcap").found == "no package rosbags"


@settings(max_examples=30)
@given(seed=seeds)
def test_a_damaged_bag_is_read_or_refused_in_one_line(arm, seed):
    rng, content = np.random.default_rng(seed), bytearray(arm.read_bytes())
    for place in rng.integers(0, len(content), 20):
        content[place] = int(rng.integers(256))
    damaged = arm.with_name(f"damaged{arm.suffix}")
    damaged.write_bytes(content)
    try:
        assert read_joint_states(damaged, None)["values"].size
    except InputError as error:
        assert "\n" not in str(error)


@pytest.fixture(scope="module", params=["MCAP", "SQLITE3"])
def arm(request, tmp_path_factory):
    folder = write(tmp_path_factory.mktemp("bags") / "arm", {"/joint_states": states()}, request.param)
    return next(path for path in folder.iterdir() if path.suffix != ".yaml")


def test_a_bag_of_ros_1_is_read_as_the_table_is(tmp_path):
    store = get_typestore(Stores.ROS1_NOETIC)
    state, header, time = (store.types[name] for name in TYPES)
    with Ros1Writer(tmp_path / "arm.bag") as writer:
        to = writer.add_connection("/joint_states", TYPES[0], typestore=store)
        for k, t in enumerate(GOOD.t):
            stamp = time(*divmod(START + round(1e9 * t), 10**9))
            q, tau = GOOD.q[:, k].copy(), GOOD.tau[:, k].copy()
            message = state(header(k, stamp, ""), ["joint1", "joint2"], q, np.zeros(0), tau)
            writer.write(to, START + round(1e9 * t), store.serialize_ros1(message, TYPES[0]))
    table = {name: values for name, values in columns(GOOD).items() if not name.startswith("d")}
    (tmp_path / "log.csv").write_text(text(table, 17))
    log, plain = read_log(tmp_path / "arm.bag", Arm()), read_log(tmp_path / "log.csv", Arm())
    np.testing.assert_allclose(log.t, plain.t, atol=1e-8)
    np.testing.assert_array_equal(log.q, plain.q)
    np.testing.assert_array_equal(log.tau, plain.tau)


def packed(pack, megabytes):
    """Zeros, packed by the functions that begin, add and end."""
    begin, add, end = pack
    return begin() + b"".join(add(bytes(1 << 24)) for _ in range(megabytes >> 4)) + end()


MEASURED = """
import sys
from pathlib import Path
from resource import RUSAGE_CHILDREN, getrusage
from repro.errors import InputError
from repro.logs.bag import read_bag
try:
    read_bag(Path(sys.argv[1]), None)
except InputError as error:
    print(error.found)
used = getrusage(RUSAGE_CHILDREN)
print(used.ru_maxrss)
print(used.ru_utime + used.ru_stime)
"""


@pytest.mark.parametrize("form", ["zstd", "lz4"])
def test_a_small_file_that_unpacks_to_gigabytes_is_refused(tmp_path, form):
    if form == "zstd":
        zstandard = ZstdCompressor()
        data = packed((bytes, zstandard.compress, zstandard.flush), 2048)
    else:
        frame = LZ4FrameCompressor()
        data = packed((frame.begin, frame.compress, frame.flush), 2048)
    text = len(form).to_bytes(4, "little") + form.encode()
    chunk = struct.pack("<QQQI", 0, 1 << 62, 2 << 30, 0) + text + struct.pack("<Q", len(data)) + data
    records = [(1, b"\4\0\0\0ros2\0\0\0\0"), (6, chunk), (2, bytes(20))]
    magic = b"\x89MCAP0\r\n"
    body = b"".join(struct.pack("<BQ", kind, len(content)) + content for kind, content in records)
    (tmp_path / "small.mcap").write_bytes(magic + body + magic)
    # In a process that has no other children, whose largest memory would count, too.
    run = subprocess.run(
        [sys.executable, "-c", MEASURED, tmp_path / "small.mcap"], capture_output=True, text=True, check=True
    )
    found, kibibytes, _ = run.stdout.splitlines()
    assert found == "contents that unpack to more than is read"
    assert int(kibibytes) < 1 << 20
