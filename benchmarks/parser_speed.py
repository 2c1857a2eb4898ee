"""Stream parser: MB/s on clean, faulty and random bytes in pieces of several sizes, and frames found but never sent."""

import argparse
import os
import time
from collections import Counter

from repro import contract

contract.hold(os.environ)

import numpy as np

from repro.board.channel_errors import ErrorInjector, ErrorRates
from repro.board.frames import FRAME_BYTES, RADIANS_PER_COUNT, SAMPLING_PERIOD, encode
from repro.board.parser import StreamParser


def motion(frames: int, rng: np.random.Generator) -> bytes:
    """Frames of two sinusoids of 1.2 and 0.9 rad with torque noise of 5 counts."""
    t = np.arange(frames) * SAMPLING_PERIOD
    position = np.rint(np.stack([1.2 * np.sin(1.3 * t), 0.9 * np.sin(2.1 * t)]) / RADIANS_PER_COUNT)
    pwm = np.rint(np.stack([400 * np.sin(1.3 * t), 300 * np.cos(2.1 * t)]) + rng.normal(0, 5, (2, frames)))
    return encode(position.astype(int), pwm.astype(int))


def parse(data: bytes, size: int) -> tuple[float, list[bytes], StreamParser]:
    """Processor time, s, frames and parser of a stream fed in pieces of `size` bytes."""
    parser = StreamParser()
    began = time.process_time()
    parts = [parser.feed(data[i : i + size]) for i in range(0, len(data), size)]
    parts.append(parser.finish())
    seconds = time.process_time() - began
    words = b"".join(encode(part.position, part.pwm) for part in parts)
    return seconds, [words[i : i + FRAME_BYTES] for i in range(0, len(words), FRAME_BYTES)], parser


def main() -> None:
    """Run the benchmark and print its table."""
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--megabytes", type=float, default=10.0)
    arguments.add_argument("--repeats", type=int, default=3)
    args = arguments.parse_args()
    rng = np.random.default_rng(0)
    n = int(1e6 * args.megabytes)
    clean = motion(n // FRAME_BYTES, rng)
    streams = {"clean": clean}
    for rate in (1e-4, 1e-3, 1e-2):
        third = rate / 3
        injector = ErrorInjector(ErrorRates(drop=third, flip=third, insert=third), rng)
        streams[f"{rate:g} faults a byte"] = injector.apply(clean)
    streams["random"] = rng.bytes(n)
    sent = Counter(clean[i : i + FRAME_BYTES] for i in range(0, len(clean), FRAME_BYTES))
    for name, data in streams.items():
        speeds = []
        for size in (len(data), 4096, 256, 1):
            part = data[: len(data) if size > 1 else len(data) // 50]
            runs = [parse(part, size) for _ in range(args.repeats)]
            speeds.append(f"{len(part) / min(run[0] for run in runs) / 1e6:.3g}")
        _, frames, parser = parse(data, len(data))
        wrong = (Counter(frames) - sent).total() if name != "random" else len(frames)
        counts = parser.counts
        print(f"{name}: {' / '.join(speeds)} MB/s whole / 4096 / 256 / 1; ", end="")
        print(f"{counts.good} frames, {wrong} never sent, {counts.skipped} bytes skipped, {counts.gaps} gaps")


if __name__ == "__main__":
    main()
