"""Captures of the five motions from wherever the configuration says: stored, simulated in process, or a serial port."""

import shutil
from dataclasses import replace
from functools import partial
from pathlib import Path

from repro.errors import InputError
from repro.files import atomic_write
from repro.fpga.capture import Capture, files_of, read_capture, write_capture
from repro.fpga.link import raw_file, record
from repro.fpga.messages import encode_start
from repro.pipeline.experiment import control_constants, metadata_for, program_from_config
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
    board, metadata = board_from_config(config), metadata_for(program, config)
    board.receive(metadata.program + encode_start(metadata.samples))
    if not board.running:
        raise InputError.at(f"simulated board: {program.name}", "; ".join(board.refusals), "a start")
    progress = Progress(f"simulating {program.name}")
    data = bytearray()
    while board.running:
        data += board.tick()
        progress(len(data) // 8, metadata.samples)
    return write_capture(out, bytes(data), replace(metadata, board=board.identity), overwrite=True)


def _record(out: Path, program: Program, config: Config) -> None:
    e, metadata = config["experiment"], metadata_for(program, config)
    with raw_file(out, metadata, overwrite=True) as raw:
        data, metadata = record(e["port"], metadata, e["baud"], keep=raw.add)
        raw.close()
        write_capture(out, data, metadata, overwrite=True)


def _copy(stored: Path, out: Path, config: Config, motion: str) -> None:
    capture = read_capture(stored)
    check_recorded(capture, program_from_config(config, motion))
    _check_set_up(capture, config)
    for there, here in zip(files_of(stored), files_of(out), strict=True):
        atomic_write(here, partial(shutil.copyfile, there))


def _check_set_up(capture: Capture, config: Config) -> None:
    """Refuse a stored capture of other gains, motors or, if it is simulated, another arm than configured."""
    expected = "that of this configuration; record it again or set experiment.source: simulated"
    if capture.metadata.control != control_constants(config):
        raise InputError.at(f"{capture.place}: control", "other gains or motors", expected)
    if capture.metadata.board is not None and capture.metadata.board != board_from_config(config).identity:
        raise InputError.at(f"{capture.place}: board", "another simulated arm", expected)
