"""Add to a capture of the first format what the board was sent; the recorded bytes stay as they are."""

import argparse
import hashlib
from pathlib import Path

from repro.commands.options import add_config
from repro.errors import InputError

#: Largest share of frames that the control law may not confirm: a bad line damages some, another motion all.
UNCONFIRMED = 0.05


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of ``repro upgrade``."""
    parser.add_argument("files", nargs="+", type=Path, help="captures NAME.bin, with NAME.json beside them")
    parser.add_argument(
        "--trajectory", help="table FILE.csv that was recorded (default: the motion named in NAME.json)"
    )
    add_config(parser)


def run(arguments: argparse.Namespace) -> int:
    """Upgrade each capture, and the check sums of its folder where there are some; exit code 0."""
    from repro.fpga.checksums import SUMS, verify_folder, write_sums
    from repro.pipeline.experiment import load_config

    config = load_config(arguments.config)
    folders = sorted({file.parent for file in arguments.files if (file.parent / SUMS).exists()})
    for folder in folders:
        verify_folder(folder)
    for file in arguments.files:
        print(upgrade(file, config, arguments.trajectory))
        if file.parent in folders:
            write_sums(file.parent)
    return 0


def upgrade(path: Path, config: dict[str, object], trajectory: str | None) -> str:
    """Write ``NAME.program`` and the new ``NAME.json`` of one capture; a line that says on what evidence."""
    from repro.commands.record import program_of
    from repro.documents import read_bytes, read_json
    from repro.files import write_json, writing
    from repro.fpga.capture import LARGEST, check_bytes, decode_capture, files_of, write_bytes
    from repro.fpga.downlink import Gains, encode_program
    from repro.fpga.recorded import verify_control
    from repro.fpga.sidecar import FORMAT, WITHOUT_PROGRAM, about_of, check_sidecar

    data_file, sent, beside = files_of(path)
    old = read_json(beside)
    if not (isinstance(old, dict) and old.get("format") == WITHOUT_PROGRAM):
        check_sidecar(str(beside), old)
        return f"{path}: has what was sent already"
    try:
        data = read_bytes(data_file, LARGEST, "a capture")
        check_bytes(data_file, data, old)
        program = program_of(config, trajectory or old["motion"])
        digest = hashlib.sha256(program.q.T.astype(">f4").tobytes()).hexdigest()
        same = digest == old["trajectory"]["sha256"]
        control = old["control"]
        download = encode_program(
            Gains(tuple(control["kp_counts"]), tuple(control["kv_counts"]), tuple(control["pwm_hz"])), program.q
        )
        content = check_sidecar(
            str(beside),
            {
                **old,
                "format": FORMAT,
                "trajectory": {name: old["trajectory"][name] for name in ("n1", "n2")},
                "program": {
                    "bytes": len(download),
                    "sha256": hashlib.sha256(download).hexdigest(),
                    "recomputed": not same,
                },
            },
        )
        capture = decode_capture(data, about_of(content, download), content["reason"], str(path))
    except (KeyError, TypeError, ValueError, OSError) as error:
        raise InputError.at(str(path), f"a capture that cannot be upgraded ({error})", "one of format 1") from error
    check = verify_control(capture)
    if check.disagree.size > UNCONFIRMED * max(check.checked, 1):
        raise InputError.at(
            f"{path}: trajectory",
            f"a recording of another {capture.about.motion}: {check.agree} of {check.checked} torques follow from it",
            "the configuration it was recorded with (--config), or its table (--trajectory)",
        )
    with writing(path):
        write_bytes(sent, download)
        write_json(beside, content)
    apart = "the hash of the motion sent" if same else "motion computed again, its last bits apart"
    return f"{path}: upgraded, {apart}; the control law confirms {check.agree} of {check.checked} torques"
