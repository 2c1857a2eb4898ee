"""Captures: what is written is read, damage is named in one line, and nothing is overwritten."""

import dataclasses
import hashlib
import json

import numpy as np
import pytest
from experiment_example import refused
from fake_board import CONTROL, IDENTITY, metadata, motion
from hypothesis import given
from hypothesis import strategies as st
from strategies import seeds

from repro.board.capture import decode_capture, read_capture, recording_of, to_table, verify_control, write_capture
from repro.board.channel_errors import ErrorInjector, ErrorRates
from repro.board.frames import encode
from repro.board.messages import encode_gains, encode_program, encode_trajectory
from repro.board.sidecar import Host
from repro.errors import InputError

DESIRED, POSITION, PWM = motion(400)
FRAMES = encode(POSITION, PWM)
METADATA = metadata(DESIRED)
CHUNKS = ((800, 0.05), (3200, 0.1))
HOST = Host(port="socket://127.0.0.1:5000", baud=115200, began="2026-01-31T12:00:00.000+00:00", chunks=CHUNKS)


@pytest.fixture
def stored(tmp_path):
    write_capture(tmp_path / "T4.bin", FRAMES, metadata(DESIRED, host=HOST))
    return tmp_path / "T4.bin"


@pytest.mark.parametrize("host", [None, HOST])
@pytest.mark.parametrize("board", [None, IDENTITY])
@pytest.mark.parametrize(("data", "reason"), [(FRAMES, ""), (FRAMES[:1001], "disconnected")])
def test_what_is_written_is_read(tmp_path, host, board, data, reason):
    host = host and host.model_copy(update={"chunks": ((800, 0.05), (len(data), 0.1))})
    given_metadata = metadata(DESIRED, board=board, host=host, end_reason=reason)
    path = tmp_path / "new" / "T4.bin"
    write_capture(path, data, given_metadata)
    assert path.stat().st_mode & 0o777 == 0o444
    capture = read_capture(path)
    n = len(data) // 8
    assert (capture.data, capture.metadata, capture.complete) == (data, given_metadata, reason == "")
    np.testing.assert_array_equal(capture.position, POSITION[:, :n])
    np.testing.assert_array_equal(capture.pwm, PWM[:, :n])
    np.testing.assert_allclose(capture.time, 0.0025 * np.arange(n), rtol=1e-12)
    np.testing.assert_allclose(capture.q, POSITION[:, :n] * 2 * np.pi / 8400, rtol=1e-12)
    np.testing.assert_allclose(capture.tau.T, PWM[:, :n].T * (np.array([2.7192, 2.7314]) / 1023), rtol=1e-12)
    np.testing.assert_array_equal(capture.metadata.desired, DESIRED.astype(np.float32))
    content = json.loads(path.with_suffix(".json").read_text())
    written = (content["source"], "host" in content, content["counts"]["good"])
    assert written == ("serial" if board is None else "simulated", host is not None, n)


def test_a_capture_is_overwritten_only_on_request(stored):
    assert refused(write_capture, stored, FRAMES[:80], METADATA).place == str(stored)
    assert read_capture(stored).data == FRAMES
    write_capture(stored, FRAMES[:80], dataclasses.replace(METADATA, end_reason="silent"), overwrite=True)
    assert read_capture(stored).counts.good == 10
    stored.unlink()
    assert refused(write_capture, stored, FRAMES, METADATA).place == str(stored.with_suffix(".program"))
    within = stored.with_suffix(".json") / "T4.bin"
    for path in (within, stored.with_suffix(".dat")):
        assert refused(write_capture, path, FRAMES, METADATA).place == str(path)


def test_a_capture_is_whole_or_absent(tmp_path):
    (tmp_path / "T4.json").mkdir()  # cannot be replaced by a file
    with pytest.raises(OSError, match="T4"):
        write_capture(tmp_path / "T4.bin", FRAMES, METADATA, overwrite=True)
    assert [path.name for path in tmp_path.iterdir()] == ["T4.json"]


@pytest.mark.parametrize(
    ("key", "value", "place", "found"),
    [
        ("format", 1, "format", "1"),
        ("source", "real", "source", "'real'"),
        ("source", "serial", "board", ""),
        ("sampling_period_s", "2.5 ms", "sampling_period_s", "'2.5 ms'"),
        ("samples_expected", 400.0, "samples_expected", "400.0"),
        ("complete", False, "complete", "False"),
        ("reason", "tired", "reason", "'tired'"),
        ("program.sha256", "abc", "program.sha256", "'abc'"),
        ("program.recomputed", True, "program.recomputed", "True"),
        ("program.bytes", 5, "T4.program: size", ""),
        ("trajectory.n2", 401, "trajectory.n2", "401"),
        ("trajectory.n2", METADATA.n1, "trajectory.n2", str(METADATA.n1)),
        ("control.kp", [1.0, -2.0], "control.kp[1]", "-2.0"),
        ("control.kv_counts", [1.0, 2.0], "control.kv_counts", "[1.0, 2.0]"),
        ("counts.good", 399, "counts.good", "399"),
        ("mood", "fine", "mood", "an unknown key"),
        ("host", {}, "host.port", "nothing"),
        ("host.chunks", [[1, "b"]], "host.chunks[0][1]", "'b'"),
        ("host.chunks", [], "host.chunks", ""),
        ("host.chunks", [[800, 0.1], [3201, 0.2]], "host.chunks", ""),
        ("host.chunks", [[-1, 0.1], [3200, 0.2]], "host.chunks", ""),
        ("host.chunks", [[9, 0], [3, 0]], "host.chunks", ""),
        ("sha256", "0" * 64, "SHA-256", ""),
        ("motion", None, "motion", "nothing"),
        ("motion", "\x1b[2J", r"motion", r"'\x1b[2J'"),
    ],
)
def test_a_wrong_sidecar_is_named_in_one_line(stored, key, value, place, found):
    sidecar = stored.with_suffix(".json")
    content = json.loads(sidecar.read_text())
    section, _, name = key.rpartition(".")
    values = content[section] if section else content
    values[name] = value
    if value is None:
        del values[name]
    sidecar.write_text(json.dumps(content))
    error = refused(read_capture, stored)
    assert error.place.startswith(str(stored.with_suffix(""))) and error.place.endswith(place)
    assert error.found.startswith(found)


@pytest.mark.parametrize(
    ("name", "content", "place", "found"),
    [
        ("T4.bin", FRAMES[:-1], "T4.bin: size", "3199 bytes"),
        ("T4.bin", FRAMES[:100] + bytes([FRAMES[100] ^ 1]) + FRAMES[101:], "T4.bin: SHA-256", ""),
        ("T4.json", None, "T4.bin", "no T4.json next to it"),
        ("T4.json", b"{", "T4.json", "text that is not JSON"),
        ("T4.json", b"[]", "T4.json: content", "[]"),
    ],
)
def test_a_wrong_file_is_named_in_one_line(stored, name, content, place, found):
    path = stored.parent / name
    path.unlink()
    if content is not None:
        path.write_bytes(content)
    error = refused(read_capture, stored)
    assert error.place == str(stored.parent / place) and error.found.startswith(found)


def test_flipped_bits_of_a_sidecar_are_refused_or_change_nothing(stored):
    sidecar = stored.with_suffix(".json")
    whole = sidecar.read_bytes()
    before = read_capture(stored).metadata
    refused = 0
    for k in np.random.default_rng(4).choice(8 * len(whole), 150, replace=False):
        damaged = bytearray(whole)
        damaged[k // 8] ^= 1 << (k % 8)
        sidecar.write_bytes(damaged)
        try:
            assert read_capture(stored).metadata == before  # a blank became another one
        except InputError as error:
            assert "\n" not in str(error)
            refused += 1
    assert refused > 100


@pytest.mark.parametrize(
    ("program", "found"),
    [
        (encode_program(CONTROL, DESIRED[:, :300]), "has 300 samples, must have the 400"),
        (METADATA.program[:-1], "belong to no intact message"),
        (encode_program(dataclasses.replace(CONTROL, kp=(1.0, 2.0)), DESIRED), "gains"),
        (encode_gains(CONTROL), "has no trajectory"),
        (encode_gains(CONTROL) + encode_trajectory(DESIRED) * 2, "a block begins at sample 0, must begin at 400"),
        (METADATA.program.replace(encode_trajectory(DESIRED[:, :256]), b""), "begins at sample 256, must begin at 0"),
        (encode_trajectory(DESIRED), "must be GAINS"),
    ],
)
def test_a_program_that_contradicts_the_sidecar_is_refused(stored, program, found):
    sent, sidecar = stored.with_suffix(".program"), stored.with_suffix(".json")
    sent.chmod(0o644)
    sent.write_bytes(program)
    content = json.loads(sidecar.read_text())
    content["program"] |= {"bytes": len(program), "sha256": hashlib.sha256(program).hexdigest()}
    sidecar.write_text(json.dumps(content))
    error = refused(read_capture, stored)
    assert error.place.startswith(str(sent)) and found in str(error)


def test_short_gaps_are_interpolated_and_recorded():
    damaged = [50, 51, 52, 200]
    data = b"".join(FRAMES[8 * i : 8 * i + 8] if i not in damaged else b"\0" * 8 for i in range(400))
    capture = decode_capture(data, METADATA)
    missing = [49, 50, 51, 52, 200]  # a frame with damaged ones behind it is not confirmed
    kept = np.setdiff1d(np.arange(400), missing)
    np.testing.assert_array_equal(capture.index, kept)
    q, tau = recording_of(capture)
    truth = decode_capture(FRAMES, METADATA)
    np.testing.assert_array_equal([q[:, kept], tau[:, kept]], [truth.q[:, kept], truth.tau[:, kept]])
    for i, (low, high) in {**dict.fromkeys(range(49, 53), (48, 53)), 200: (199, 201)}.items():
        slope = (truth.tau[:, high] - truth.tau[:, low]) / (high - low)
        np.testing.assert_allclose(tau[:, i], truth.tau[:, low] + (i - low) * slope, rtol=1e-12, atol=1e-15)
    table = to_table(capture)
    names = "time_s q1_rad q2_rad tau1_Nm tau2_Nm q1_counts q2_counts pwm1 pwm2 gap simulated"
    assert list(table.columns) == names.split()
    sent = np.concatenate([POSITION, PWM])
    np.testing.assert_array_equal(table[["q1_counts", "q2_counts", "pwm1", "pwm2"]].T, sent[:, kept])
    assert table.index[table["gap"] == 1].tolist() == [49, 196]
    np.testing.assert_allclose(table["time_s"], 0.0025 * kept, rtol=1e-12)


@pytest.mark.parametrize(
    ("data", "reason", "place", "found"),
    [
        (FRAMES[:800], "silent", "", "an incomplete recording (silent)"),
        (FRAMES[:800] + bytes(40) + FRAMES[840:], "", "byte 792", "a gap of about 6 samples"),
        (bytes(8) + FRAMES[8:], "", "byte 0", "a gap of about 1 samples"),
        (FRAMES[:-8] + bytes(8), "", "byte 3184", "a gap of about 2 samples"),
        (FRAMES[:800], "", "samples", "100 and about 0 lost"),
    ],
)
def test_recordings_with_long_gaps_are_refused(data, reason, place, found):
    capture = decode_capture(data, dataclasses.replace(METADATA, end_reason=reason))
    error = refused(recording_of, capture)
    assert error.place.endswith(place) and error.found.startswith(found)


def test_the_control_law_confirms_every_frame_that_it_can():
    # Two frames are damaged, the one before them is not confirmed, and the one behind them has none before it.
    checked, differing = verify_control(decode_capture(FRAMES[:800] + bytes(16) + FRAMES[816:], METADATA))
    assert (checked, differing.size) == (396, 0)


@given(frame=st.integers(0, 399), bit=st.sampled_from([40, 24, *range(2, 24)]))
def test_the_control_law_finds_flipped_bits_that_the_parser_cannot(frame, bit):
    assert (abs(PWM) < 1023).all()  # a saturated torque would not depend on the position
    word = int.from_bytes(FRAMES[8 * frame : 8 * frame + 8], "big") ^ 1 << bit
    capture = decode_capture(FRAMES[: 8 * frame] + word.to_bytes(8, "big") + FRAMES[8 * frame + 8 :], METADATA)
    disagree = verify_control(capture)[1].tolist()
    if capture.counts.good == 400:  # else the flip made a torque of -1024 or a jump, which the parser sees
        assert frame in disagree
    assert set(disagree) <= {frame, frame + 1}


@pytest.mark.slow
@given(seed=seeds, rates=st.tuples(*[st.sampled_from([0.0, 1e-3, 1e-2])] * 3))
def test_channel_errors_never_break_the_reader(seed, rates):
    injector = ErrorInjector(ErrorRates(*rates), np.random.default_rng(seed))
    data = injector.apply(FRAMES)
    capture = decode_capture(data, METADATA)
    counts, errors = capture.counts, injector.counts.total()
    assert counts.received == len(data) == 8 * counts.good + counts.skipped
    assert np.all(np.diff(capture.index) > 0)
    assert 400 - 2 * errors - 8 * (errors > 3) <= counts.good <= 400 + injector.counts["insert"] // 8
    if errors == 0:
        assert (counts.good, counts.gaps, verify_control(capture)[1].size) == (400, 0, 0)
    try:
        q, tau = recording_of(capture)
    except InputError as error:
        assert "\n" not in str(error)
    else:
        assert q.shape == tau.shape == (2, 400)
