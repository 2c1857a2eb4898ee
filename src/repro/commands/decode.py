"""Decode a capture file: what is in it, and its samples as a table."""

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from repro.errors import InputError

if TYPE_CHECKING:
    from repro.fpga.capture import Capture


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of ``repro decode``."""
    parser.add_argument("file", type=Path, help="capture NAME.bin, with NAME.json next to it")
    parser.add_argument("-o", "--out", help="table to write, FILE.csv, or - for standard output")
    parser.add_argument("--overwrite", action="store_true", help="replace a table that is there")


def run(arguments: argparse.Namespace) -> int:
    """Check, decode, summarise, and write the table if requested."""
    from repro.files import CSV_FLOAT_FORMAT, write_csv, writing
    from repro.fpga.capture import files_of, read_capture
    from repro.fpga.recording import to_table

    out = arguments.out
    if out not in (None, "-") and Path(out).exists():
        if not arguments.overwrite:
            raise InputError.at(out, "a file", "a new name, or --overwrite")
        if any(each.exists() and each.samefile(out) for each in files_of(arguments.file)):
            raise InputError.at(out, "a file of the capture itself", "another name")
    if out not in (None, "-") and not out.endswith(".csv"):
        raise InputError.at("--out", repr(out), "FILE.csv, or -")
    capture = read_capture(arguments.file)
    if out == "-":
        print(summary(capture), file=sys.stderr)
        to_table(capture).to_csv(sys.stdout, index=False, float_format=CSV_FLOAT_FORMAT, lineterminator="\n")
        return 0
    if out is not None:
        with writing(out):
            write_csv(Path(out), to_table(capture))
    print(summary(capture))
    return 0


def summary(capture: "Capture") -> str:
    """Summarise a capture in three lines."""
    metadata, counts = capture.metadata, capture.counts
    state = "complete" if capture.complete else f"incomplete ({metadata.end_reason})"
    return "\n".join(
        (
            f"{capture.place}: {metadata.motion}, source {metadata.source}, {state}",
            f"frames: {counts.good} good of {metadata.samples} expected ({metadata.samples * metadata.h:g} s)",
            f"gaps: {counts.gaps}, about {counts.lost} frames lost, {counts.skipped} bytes skipped",
        )
    )
