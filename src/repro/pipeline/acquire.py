"""Captures of the five motions from wherever the configuration says: stored, simulated in process, or a serial port."""

import shutil
from functools import partial
from pathlib import Path

from repro.errors import InputError
from repro.files import write_whole
from repro.fpga.capture import Capture, files_of, read_capture, write_capture
from repro.fpga.link import LinkSettings, record
from repro.fpga.rawfile import raw_file
from repro.pipeline.experiment import control_constants, describe, download, program_from_config
from repro.pipeline.job import Config
from repro.pipeline.recordings import check_recorded
from repro.pipeline.specimen import board_from_config
from repro.progress import Progress
from repro.signals.programs import Program


def acquire(motion: str, out: Path, config: Config) -> None:
    """Put the capture of a motion at `out`."""
    source = config["experiment"]["source"]
    if source == "stored":
        _copy(Path(config["experiment"]["captures"]) / f"{motion}.bin", out, config, motion)
    elif source == "simulated":
        simulate_capture(out, program_from_config(config, motion), config)
    else:
        _record(out, program_from_config(config, motion), config)


def simulate_capture(out: Path, program: Program, config: Config) -> Capture:
    """Capture of the simulated board run in this process, byte for byte what it sends over a line."""
    control = control_constants(config)
    board = board_from_config(config)
    load, start = download(program, control)
    board.receive(load + start)
    if not board.running:
        raise InputError.at(f"simulated board: {program.name}", "; ".join(board.refusals), "a start")
    progress, n = Progress(f"simulating {program.name}"), program.q.shape[1]
    data = bytearray()
    while board.running:
        data += board.tick()
        progress(len(data) // 8, n)
    return write_capture(out, bytes(data), describe(program, control, board.identity), overwrite=True)


def _record(out: Path, program: Program, config: Config) -> None:
    e, control = config["experiment"], control_constants(config)
    load, start = download(program, control)
    n = program.q.shape[1]
    with raw_file(out, n, len(load), overwrite=True) as raw:
        recording = record(e["port"], load, start, n, LinkSettings(e["baud"]), raw.add)
        raw.close()
        about = describe(program, control, recording.board, recording.host)
        write_capture(out, recording.data, about, recording.reason, overwrite=True)


def _copy(stored: Path, out: Path, config: Config, motion: str) -> None:
    capture = read_capture(stored)
    check_recorded(capture, program_from_config(config, motion))
    _check_set_up(capture, config)
    for there, here in zip(files_of(stored), files_of(out), strict=True):
        write_whole(here, partial(shutil.copyfile, there))


def _check_set_up(capture: Capture, config: Config) -> None:
    """Refuse a stored capture of other gains, motors or, if it is simulated, another arm than configured."""
    expected = "that of this configuration; record it again or set experiment.source: simulated"
    if capture.about.control != control_constants(config):
        raise InputError.at(f"{capture.place}: control", "other gains or motors", expected)
    if capture.about.board is not None and capture.about.board != board_from_config(config).identity:
        raise InputError.at(f"{capture.place}: board", "another simulated arm", expected)
