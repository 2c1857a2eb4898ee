"""Captures: what is written is read, damage is named in one line, and nothing is overwritten."""

import dataclasses
import hashlib
import json
import subprocess

import numpy as np
import pytest
from fake_board import CONTROL, about, download, frames_of, motion
from hypothesis import given, settings
from hypothesis import strategies as st

from repro.errors import InputError
from repro.fpga.about import Host
from repro.fpga.capture import decode_capture, read_capture, write_capture
from repro.fpga.checksums import verify_folder, write_sums
from repro.fpga.downlink import Gains, encode_gains, encode_trajectory, parse_program
from repro.fpga.faults import FaultInjector, FaultSettings
from repro.fpga.frames import encode
from repro.fpga.recorded import samples, to_table, verify_control

DESIRED, POSITION, PWM = motion(400)
FRAMES = encode(POSITION, PWM)
ABOUT = about(DESIRED)
GAINS = Gains(tuple(CONTROL.kp_counts.tolist()), tuple(CONTROL.kv_counts.tolist()), CONTROL.pwm_hz)
HOST = Host("socket://127.0.0.1:5000", 115200, "2026-01-31T12:00:00.000+00:00", ((800, 0.05), (3200, 0.1)))


@pytest.fixture
def stored(tmp_path):
    write_capture(tmp_path / "T4.bin", FRAMES, ABOUT)
    return tmp_path / "T4.bin"


@pytest.mark.parametrize("host", [None, HOST])
@pytest.mark.parametrize("board", [None, {"plant": {"ripple": 0.05}, "name": "simulated"}])
@pytest.mark.parametrize(("data", "reason"), [(FRAMES, ""), (FRAMES[:1001], "disconnected")])
def test_what_is_written_is_read(tmp_path, host, board, data, reason):
    told = about(DESIRED, board, host)
    path = tmp_path / "new" / "T4.bin"
    write_capture(path, data, told, reason)
    assert path.read_bytes() == data
    assert path.stat().st_mode & 0o777 == 0o444
    capture = read_capture(path)
    n = len(data) // 8
    assert (capture.data, capture.about, capture.reason) == (data, told, reason)
    assert capture.complete == (reason == "")
    np.testing.assert_array_equal(capture.position, POSITION[:, :n])
    np.testing.assert_array_equal(capture.pwm, PWM[:, :n])
    np.testing.assert_allclose(capture.time, 0.0025 * np.arange(n), rtol=1e-12)
    np.testing.assert_allclose(capture.q, POSITION[:, :n] * 2 * np.pi / 8400, rtol=1e-12)
    np.testing.assert_allclose(capture.tau.T, PWM[:, :n].T * (np.array([2.7192, 2.7314]) / 1023), rtol=1e-12)
    content = json.loads(path.with_suffix(".json").read_text())
    assert content["source"] == ("serial" if board is None else "simulated")
    assert ("host" in content) == (host is not None)
    assert content["counts"]["good"] == n


def test_a_recording_made_in_process_gives_the_same_files_every_time(tmp_path):
    for name in "ab":
        write_capture(tmp_path / name / "T4.bin", FRAMES, ABOUT)
    for name in ("T4.bin", "T4.program", "T4.json"):
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()


def test_a_capture_is_overwritten_only_if_told(stored):
    before = {path.name: path.read_bytes() for path in stored.parent.iterdir()}
    with pytest.raises(InputError, match=r"T4\.bin: found a file"):
        write_capture(stored, FRAMES[:80], ABOUT)
    assert {path.name: path.read_bytes() for path in stored.parent.iterdir()} == before
    write_capture(stored, FRAMES[:80], ABOUT, "silent", overwrite=True)
    assert read_capture(stored).counts.good == 10
    stored.unlink()
    with pytest.raises(InputError, match=r"T4\.program: found a file"):
        write_capture(stored, FRAMES, ABOUT)
    with pytest.raises(InputError, match=r"T4\.json, where nothing can be written"):
        write_capture(stored.with_suffix(".json") / "T4.bin", FRAMES, ABOUT)
    with pytest.raises(InputError, match="suffix"):
        write_capture(stored.with_suffix(".dat"), FRAMES, ABOUT)


def test_a_capture_is_whole_or_absent(tmp_path):
    (tmp_path / "T4.json").mkdir()  # cannot be replaced by a file
    with pytest.raises(OSError, match="T4"):
        write_capture(tmp_path / "T4.bin", FRAMES, ABOUT, overwrite=True)
    assert [path.name for path in tmp_path.iterdir()] == ["T4.json"]


def test_a_capture_that_cannot_be_replaced_stays(stored, monkeypatch):
    def full(path, write):
        raise OSError("disk full")

    before = {path.name: path.read_bytes() for path in stored.parent.iterdir()}
    monkeypatch.setattr("repro.fpga.capture.write_whole", full)
    with pytest.raises(OSError, match="disk full"):
        write_capture(stored, FRAMES[:80], ABOUT, "silent", overwrite=True)
    assert {path.name: path.read_bytes() for path in stored.parent.iterdir()} == before


def change(*keys, to):
    """A change of one value of the sidecar."""

    def apply(content):
        node = content
        for key in keys[:-1]:
            node = node[key]
        node[keys[-1]] = to

    return apply


@pytest.mark.parametrize(
    ("apply", "told"),
    [
        (change("format", to=3), "format: found 3, expected 2"),
        (change("format", to=True), "format: found True, expected 2"),
        (change("source", to="real"), "source: found 'real', expected simulated or serial"),
        (change("source", to="serial"), "board: found"),
        (change("sampling_period_s", to="2.5 ms"), "sampling_period_s: found '2.5 ms', expected 5e-05 to 0.2 s"),
        (change("samples_expected", to=400.0), "samples_expected: found 400.0, expected an integer"),
        (change("complete", to=False), "complete: found False, expected true if and only if"),
        (change("reason", to="tired"), "reason: found 'tired', expected one of"),
        (change("program", "sha256", to="abc"), "program.sha256: found 'abc', expected a SHA-256"),
        (change("program", "sha256", to="0" * 64), "T4.program: SHA-256: found"),
        (change("program", "bytes", to=5), "T4.program: size: found"),
        (change("trajectory", "n2", to=401), "trajectory.n2: found 401, expected more than n1"),
        (change("trajectory", to=[]), "trajectory: found [], expected an object"),
        (change("control", "kp", to=[1.0]), "control.kp: found [1.0], expected two positive numbers"),
        (change("control", "kp", to=[1.0, -2.0]), "control.kp[1]: found -2.0, expected two positive numbers"),
        (change("control", "kv_counts", to=[1.0, 2.0]), "control.kv_counts: found [1.0, 2.0], expected"),
        (change("counts", "good", to=399), "counts.good: found 399, expected 400"),
        (change("counts", "colour", to=1), "counts.colour: found an unknown key"),
        (change("mood", to="fine"), "mood: found an unknown key"),
        (change("host", to={}), "host.port: found nothing, expected a value"),
        (change("sha256", to="0" * 64), "SHA-256: found"),
        (lambda content: content.pop("motion"), "motion: found nothing, expected a value"),
        (lambda content: content["counts"].pop("lost"), "counts.lost: found nothing, expected a value"),
    ],
)
def test_a_sidecar_that_is_wrong_is_told_in_one_line(stored, apply, told):
    beside = stored.with_suffix(".json")
    content = json.loads(beside.read_text())
    apply(content)
    beside.write_text(json.dumps(content))
    with pytest.raises(InputError) as caught:
        read_capture(stored)
    assert told in str(caught.value)
    assert "T4." in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("name", "content", "told"),
    [
        ("T4.bin", FRAMES[:-1], r"T4\.bin: size: found 3199 bytes, expected the 3200 of T4\.json"),
        ("T4.bin", FRAMES[:100] + bytes([FRAMES[100] ^ 1]) + FRAMES[101:], r"T4\.bin: SHA-256: found"),
        ("T4.bin", None, r"T4\.bin: found No such file"),
        ("T4.json", None, r"T4\.json: found No such file"),
        ("T4.json", b"{", r"T4\.json: found text that is not JSON"),
        ("T4.json", b"[]", r"T4\.json: content: found \[\], expected an object"),
        ("T4.json", b"\xff", r"T4\.json: found text that is not JSON"),
    ],
)
def test_a_file_that_is_wrong_is_told_in_one_line(stored, name, content, told):
    path = stored.parent / name
    path.unlink()
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(InputError, match=told) as caught:
        read_capture(stored)
    assert "\n" not in str(caught.value)


def test_short_gaps_are_bridged_and_told():
    damaged = [50, 51, 200]
    data = b"".join(FRAMES[8 * i : 8 * i + 8] if i not in damaged else b"\0" * 8 for i in range(400))
    capture = decode_capture(data, ABOUT)
    missing = [49, 50, 51, 200]  # a frame with two damaged ones behind it is not confirmed
    kept = np.setdiff1d(np.arange(400), missing)
    np.testing.assert_array_equal(capture.index, kept)
    result = samples(capture)
    assert result.filled == 4
    truth = decode_capture(FRAMES, ABOUT)
    np.testing.assert_array_equal(result.q[:, kept], truth.q[:, kept])
    np.testing.assert_array_equal(result.tau[:, kept], truth.tau[:, kept])
    for i, (low, high) in {49: (48, 52), 50: (48, 52), 51: (48, 52), 200: (199, 201)}.items():
        slope = (truth.tau[:, high] - truth.tau[:, low]) / (high - low)
        np.testing.assert_allclose(result.tau[:, i], truth.tau[:, low] + (i - low) * slope, rtol=1e-12, atol=1e-15)
    table = to_table(capture)
    assert table.index[table["gap"] == 1].tolist() == [49, 197]
    np.testing.assert_allclose(table["time_s"], 0.0025 * kept, rtol=1e-12)


@pytest.mark.parametrize(
    ("data", "reason", "told"),
    [
        (FRAMES[:800], "silent", r"incomplete recording \(silent\)"),
        (FRAMES[:800] + bytes(40) + FRAMES[840:], "", "byte 792: found a gap of about 6 samples, expected at most 4"),
        (bytes(8) + FRAMES[8:], "", "byte 0: found a gap of about 1 samples"),
        (FRAMES[:-8] + bytes(8), "", "byte 3184: found a gap of about 2 samples"),
        (FRAMES[:800], "", "samples: found 100 and about 0 lost, expected 400 together"),
    ],
)
def test_recordings_with_holes_are_refused(data, reason, told):
    with pytest.raises(InputError, match=told) as caught:
        samples(decode_capture(data, ABOUT, reason))
    assert "\n" not in str(caught.value)


def test_the_table_has_the_frames():
    table = to_table(decode_capture(FRAMES, ABOUT))
    names = "time_s q1_rad q2_rad tau1_Nm tau2_Nm q1_counts q2_counts pwm1 pwm2 gap simulated"
    assert list(table.columns) == names.split()
    assert len(table) == 400
    np.testing.assert_array_equal(table[["pwm1", "pwm2"]].to_numpy().T, PWM)
    np.testing.assert_array_equal(table[["q1_counts", "q2_counts"]].to_numpy().T, POSITION)
    assert not table["gap"].any()


def test_the_control_law_confirms_every_frame():
    check = verify_control(decode_capture(FRAMES, ABOUT))
    assert (check.checked, check.agree, check.disagree.size) == (400, 400, 0)


@given(frame=st.integers(0, 399), bit=st.sampled_from([40, 24, *range(2, 24)]))
def test_the_control_law_finds_flipped_bits_the_parser_cannot(frame, bit):
    assert (abs(PWM) < 1023).all()  # a saturated torque would not depend on the position
    word = int.from_bytes(FRAMES[8 * frame : 8 * frame + 8], "big") ^ 1 << bit
    capture = decode_capture(FRAMES[: 8 * frame] + word.to_bytes(8, "big") + FRAMES[8 * frame + 8 :], ABOUT)
    disagree = verify_control(capture).disagree.tolist()
    if capture.counts.good == 400:  # else the flip made a torque of -1024 or a jump, which the parser sees
        assert frame in disagree
    assert set(disagree) <= {frame, frame + 1}


def test_after_a_gap_the_check_goes_on():
    capture = decode_capture(FRAMES[:800] + bytes(16) + FRAMES[816:], ABOUT)
    check = verify_control(capture)
    # Two frames are damaged, the one before them is not confirmed, and the one behind them has none before it.
    assert (check.checked, check.agree) == (396, 396)


def test_a_capture_brings_what_the_board_was_sent(stored):
    about = read_capture(stored).about
    np.testing.assert_array_equal(about.desired, DESIRED.astype(np.float32))
    gains, _ = parse_program(about.program)
    assert (gains.kp, gains.kv) == (tuple(CONTROL.kp_counts.tolist()), tuple(CONTROL.kv_counts.tolist()))


def vouch_for(stored, program):
    """Another program beside a capture, with a sidecar that vouches for it."""
    sent, sidecar = stored.with_suffix(".program"), stored.with_suffix(".json")
    sent.chmod(0o644)
    sent.write_bytes(program)
    content = json.loads(sidecar.read_text())
    content["program"] |= {"bytes": len(program), "sha256": hashlib.sha256(program).hexdigest()}
    sidecar.write_text(json.dumps(content))


@pytest.mark.parametrize(
    ("program", "told"),
    [
        (download(DESIRED[:, :300]), "has 300 samples, must have the 400"),
        (download(DESIRED)[:-1], "belong to no intact message"),
        (b"", "0 of 0 bytes belong to no intact message"),
        (
            download(DESIRED).replace(encode_gains(GAINS), encode_gains(dataclasses.replace(GAINS, kp=(1.0, 2.0)))),
            "gains",
        ),
        (encode_gains(GAINS), "has no trajectory"),
        (encode_gains(GAINS) + encode_trajectory(DESIRED) * 2, "a block begins at sample 0, must begin at 400"),
        (encode_trajectory(DESIRED), "must be GAINS"),
    ],
)
def test_a_program_that_is_not_what_the_sidecar_says_is_refused(stored, program, told):
    vouch_for(stored, program)
    with pytest.raises(InputError, match=told) as caught:
        read_capture(stored)
    assert str(caught.value).startswith(f"{stored.with_suffix('.program')}: ")


@pytest.mark.slow
@settings(max_examples=1000)
@given(
    seed=st.integers(0, 2**32 - 1),
    rates=st.tuples(*[st.sampled_from([0.0, 1e-3, 1e-2])] * 3),
)
def test_faults_never_break_the_reader(seed, rates):
    injector = FaultInjector(FaultSettings(*rates), np.random.default_rng(seed))
    data = injector.apply(FRAMES)
    capture = decode_capture(data, ABOUT)
    counts, faults = capture.counts, len(injector.log)
    assert counts.received == len(data) == 8 * counts.good + counts.skipped
    assert np.all(np.diff(capture.index) > 0)
    assert 400 - 2 * faults - 8 * (faults > 3) <= counts.good <= 400 + injector.counts()["insert"] // 8
    if faults == 0:
        assert (counts.good, counts.gaps, verify_control(capture).agree) == (400, 0, 400)
    try:
        result = samples(capture)
    except InputError as error:
        assert "\n" not in str(error)
    else:
        assert result.q.shape == result.tau.shape == (2, 400)
        assert result.filled == 400 - counts.good


def test_a_folder_is_verified_against_its_list(stored):
    folder = stored.parent
    with pytest.raises(InputError, match="no readable list"):
        verify_folder(folder)
    write_sums(folder)
    assert verify_folder(folder) == ("T4.bin", "T4.json", "T4.program")
    run = subprocess.run(["sha256sum", "--check", "SHA256SUMS"], cwd=folder, capture_output=True, check=False)
    assert run.returncode == 0
    write_capture(folder / "T3.bin", FRAMES, dataclasses.replace(ABOUT, motion="T3"))
    with pytest.raises(InputError, match=r"T3\.bin: found a file, expected only those listed"):
        verify_folder(folder)
    write_sums(folder)
    stored.chmod(0o644)
    stored.write_bytes(FRAMES[:-8])
    with pytest.raises(InputError, match=r"T4\.bin: SHA-256: found"):
        verify_folder(folder)
    stored.unlink()
    with pytest.raises(InputError, match=r"T4\.bin: found no file"):
        verify_folder(folder)
    (folder / "SHA256SUMS").write_text("what\n")
    with pytest.raises(InputError, match="line 1: found 'what'"):
        verify_folder(folder)


def test_constants_stand_in_both_units():
    desired, frames = frames_of(20)
    capture = decode_capture(frames, about(desired))
    full = capture.about.control.torque_per_count * 1023
    np.testing.assert_allclose(full, CONTROL.full_torque)


@pytest.mark.parametrize("host", [None, HOST])
def test_every_flipped_bit_of_a_sidecar_is_refused_or_changes_nothing(stored, tmp_path, host):
    path = tmp_path / "other" / "T4.bin"
    write_capture(path, FRAMES, about(DESIRED, {"ripple_cycles": 17.0, "name": "simulated"}, host))
    sidecar = path.with_suffix(".json")
    whole = sidecar.read_bytes()
    before = read_capture(path).about
    refused = 0
    for k in np.random.default_rng(4).choice(8 * len(whole), 150, replace=False):
        damaged = bytearray(whole)
        damaged[k // 8] ^= 1 << (k % 8)
        sidecar.write_bytes(damaged)
        try:
            assert read_capture(path).about == before  # a blank became another one
        except InputError as error:
            assert "\n" not in str(error)
            refused += 1
    assert refused > 100


@pytest.mark.parametrize("period", [1e-300, 4e-5, 0.21, 1e300])
def test_a_period_that_no_arm_is_sampled_with_is_refused(stored, period):
    path = stored.with_suffix(".json")
    content = json.loads(path.read_text())
    path.write_text(json.dumps({**content, "sampling_period_s": period}))
    with pytest.raises(InputError, match="sampling_period_s: found"):
        read_capture(stored)
