"""The ``repro`` command whatever the subcommand: options, exit codes, names that no file has, and full disks."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from experiment_example import refusal_in

import repro
from repro.cli import COMMANDS, main

ROOT = Path(__file__).resolve().parents[2]
CONFIG = ROOT / "config" / "config.yaml"
CAPTURE = ROOT / "data" / "captures" / "T4.bin"


@pytest.mark.parametrize(
    ("argv", "place", "found"),
    [
        (["record", "--trajectory", "ID", "--out", "x.bin", "--timeout", "0"], "--timeout", "'0'"),
        (["record", "--trajectory", "ID", "--out", "x.bin", "--timeout", "soon"], "--timeout", "'soon'"),
        (["simulate", "--seed", "-1"], "--seed", "'-1'"),
        (["simulate", "--host", "127.0.0.1"], "--host", "--listen pty"),
        (["simulate", "--listen", "socket", "--link", "x"], "--link", "--listen socket"),
        (["simulate", "--faults", "drop"], "--faults: drop", "''"),
        (["simulate", "--faults", "drop=1e-4,drop=1e-4"], "--faults", "'drop=1e-4'"),
        (["simulate", "--faults", "flip=-0.1"], "--faults: flip", "'-0.1'"),
        (["simulate", "--faults", "drop=0.4,flip=0.4,insert=0.4"], "--faults", "drop=0.4,flip=0.4,insert=0.4"),
        (["simulate", "--faults", "disconnect_after=1.5"], "--faults: disconnect_after", "'1.5'"),
        (["decode", "ID.bin", "-o", "table.xlsx"], "--out", "'table.xlsx'"),
        (["identify", "data/captures/ID.bin", "-o", ""], "--out", "''"),
        (["identify", "LOG.csv", "-o", "new", "--trajectory", "T1"], "--trajectory", "'T1'"),
    ],
)
def test_options_that_make_no_sense_are_refused_in_one_line(monkeypatch, capsys, argv, place, found):
    monkeypatch.setattr("repro.board.server.serve", None)  # a board that is served has no end
    with pytest.raises(SystemExit) as stop:
        sys.exit(main(argv))
    assert stop.value.code == 2
    error = refusal_in(capsys.readouterr().err)
    assert error.place.endswith(place) and error.found == found


@pytest.mark.parametrize(
    ("argv", "option"), [(["record", "--out", "x.bin"], "--trajectory"), (["identify", "log.csv"], "--out")]
)
def test_a_missing_argument_is_named_in_one_line(capsys, argv, option):
    with pytest.raises(SystemExit) as stop:
        main(argv)
    (line,) = capsys.readouterr().err.splitlines()
    assert stop.value.code == 2 and option in line


def test_control_c_gives_exit_code_130_and_a_fault_of_ours_a_traceback(monkeypatch):
    errors = [RuntimeError("ours"), KeyboardInterrupt()]

    def fail(arguments):
        raise errors.pop()

    monkeypatch.setitem(COMMANDS, "decode", (COMMANDS["decode"][0], fail))
    assert main(["decode", "T4.bin"]) == 130
    with pytest.raises(RuntimeError, match="ours"):
        main(["decode", "T4.bin"])


@pytest.mark.slow
def test_python_m_repro_and_a_reader_that_has_seen_enough():
    module = [sys.executable, "-m", "repro"]
    run = subprocess.run([*module, "--help"], capture_output=True, text=True, check=True)
    assert all(name in run.stdout for name in COMMANDS)
    pipe = f"{sys.executable} -m repro decode {CAPTURE} -o - | head -n 1"
    run = subprocess.run(pipe, shell=True, capture_output=True, text=True, check=True)
    assert run.stdout.startswith("time_s,")
    assert "Traceback" not in run.stderr


def test_standard_output_that_is_full():
    with Path("/dev/full").open("w") as full:
        command = [sys.executable, "-m", "repro", "decode", str(CAPTURE), "-o", "-"]
        run = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert run.returncode == 2
    assert refusal_in(run.stderr.splitlines()[-1]).place == "output"


def test_decode_and_identify_leave_nothing_on_a_full_disk(tmp_path, refused, limit_files):
    limit_files(100_000)
    assert refused("decode", CAPTURE, "-o", tmp_path / "T4.csv").place == str(tmp_path / "T4.csv")
    assert refused("identify", tmp_path / "no-such-log.csv", "-o", tmp_path / "out").place == str(tmp_path / "out")
    assert list(tmp_path.iterdir()) == []


def test_an_output_behind_a_link_that_leads_nowhere_is_refused_before_any_work(tmp_path, refused):
    (tmp_path / "loop").symlink_to("loop")
    out = tmp_path / "loop/new"
    for argv in (
        ("record", "--port", "none", "--trajectory", "ID", "--out", f"{out}.bin"),
        ("identify", "gone.csv", "-o", out),
        ("excite", "--arm", "gone.yaml", "-o", out),
    ):
        assert refused(*argv).place.startswith(str(out))


@pytest.mark.parametrize("name", ["x" * 5000, "\udcff", "a\nb", "\x1b[31m"], ids=["long", "byte", "n", "esc"])
def test_names_that_no_file_can_have(tmp_path, refused, name):
    for argv in (
        ["identify", f"{name}.csv", "-o", tmp_path / "out"],
        ["identify", CAPTURE, "--validate", f"{name}.csv", "-o", tmp_path / "out"],
        ["decode", CAPTURE, "-o", tmp_path / f"{name}.csv"],
        ["excite", "--arm", f"{name}.yaml", "-o", tmp_path / "out"],
    ):
        assert len(str(refused(*argv))) < 11_000
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("text", ["\x9b2J", "\u202efdp", "\u2028line", "\x85next"])
def test_what_a_terminal_would_obey_is_escaped_in_all_that_is_printed(tmp_path, capsys, text):
    folder = tmp_path / text
    folder.mkdir()
    (folder / "my.yaml").write_text("{}")
    assert main(["check", "--config", str(CONFIG), str(folder / "my.yaml")]) == 0
    assert main(["decode", str(CAPTURE), "-o", str(folder / "T4.csv")]) == 0
    with pytest.raises(SystemExit):
        main([text])
    out, err = capsys.readouterr()
    assert ascii(text)[1:-1] in out and ascii(text)[1:-1] in err.replace("\\\\", "\\")
    assert all(line.isprintable() for line in (out + err).split("\n"))
    assert (folder / "T4.csv").read_text().startswith("time_s,")


def test_what_is_no_file_is_refused_by_every_command(tmp_path, refused):
    pipe, out = tmp_path / "pipe.csv", tmp_path / "out"
    os.mkfifo(pipe)
    for argv in (
        ["identify", pipe, "-o", out],
        ["identify", CAPTURE, "--arm", pipe, "-o", out],
        ["identify", CAPTURE, "--validate", pipe, "-o", out],
        ["excite", "--arm", pipe, "-o", out],
        ["excite", "--arm", pipe, "-o", "/", "--overwrite"],
        ["excite", "--arm", ROOT / "none.yaml", "--guess", pipe, "-o", out],
        ["check", pipe, "--config", CONFIG],
        ["record", "--trajectory", pipe, "--out", tmp_path / "x.bin", "--config", CONFIG],
    ):
        refused(*argv)
    assert list(tmp_path.iterdir()) == [pipe]


@pytest.mark.parametrize(
    ("content", "place"),
    [
        (b"training: {stepz: 1}\n", "training.stepz"),
        (b"training: {steps: 1, steps: 2}\n", "line 1"),
        (b"experiment: {captures: README.md}\n", "experiment.captures"),
        (b"training: {source: stored, networks: none}\n", "training.networks"),
    ],
)
def test_check_refuses_what_snakemake_would(tmp_path, refused, content, place):
    file = tmp_path / "my.yaml"
    file.write_bytes(content)
    assert refused("check", "--config", CONFIG, file).place == f"{file}: {place}"


@pytest.mark.parametrize(
    ("argv", "place", "likely"),
    [
        (["identfy", "log.csv"], "COMMAND", "identify"),
        (["identify", "l", "-o", "o", "--method", "ls"], "--method", "least-squares"),
        (["identify", "l", "-o", "o", "--metod=ordinary"], "repro identify: option", "--method"),
        (["identify", "l", "--outt", "o"], "repro identify: option", "--out"),  # before the missing --out
    ],
)
def test_the_likely_name_is_proposed_for_a_mistyped_one(capsys, argv, place, likely):
    with pytest.raises(SystemExit):
        main(argv)
    error = refusal_in(capsys.readouterr().err.splitlines()[-1])
    assert error.place.endswith(place) and error.expected.startswith(f"{likely}, or one of ")


def test_the_command_alone_prints_its_help(capsys):
    assert main([]) == 2
    printed = capsys.readouterr().err
    assert all(f"\n    {name} " in printed for name in COMMANDS)


def test_the_version_names_the_commit_of_a_checkout(capsys, monkeypatch):
    for checkout, expected in (
        (True, f"repro {repro.__version__}, commit abc\n"),
        (False, f"repro {repro.__version__}\n"),
    ):
        monkeypatch.setattr("repro.provenance.commit", lambda _: "abc")
        monkeypatch.setattr(Path, "exists", lambda _, there=checkout: there)
        with pytest.raises(SystemExit) as stop:
            main(["--version"])
        assert not stop.value.code and capsys.readouterr().out == expected
