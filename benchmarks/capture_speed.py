"""Simulated captures: processor time of one arm behind its board, and of one arm in a batch."""

import argparse
import os
import time
from pathlib import Path

from repro import contract

contract.hold(os.environ)

import numpy as np

from repro.board.controller import simulate
from repro.board.frames import encode
from repro.board.messages import encode_start
from repro.board.plant import Plant
from repro.config.check import load_config
from repro.config.sections import changed
from repro.experiments.arm import (
    board_from_config,
    control_constants,
    disturbance,
    metadata_for,
    program_from_config,
    true_parameters,
)
from repro.signals.programs import ReferenceTrajectory


def capture(config, program: ReferenceTrajectory) -> bytes:
    """Frames of the arm's board, from the download to the last sample."""
    board = board_from_config(config)
    metadata = metadata_for(program, config)
    board.receive(metadata.program + encode_start(metadata.samples))
    frames = bytearray()
    while board.running:
        frames += board.tick()
    return bytes(frames)


def batch(config, program: ReferenceTrajectory, count: int) -> list[bytes]:
    """Frames of many arms that differ in the phase of their ripple, simulated side by side."""
    effects, phase = disturbance(config)
    phases = [phase, *np.random.default_rng(1).uniform(0.0, 2.0 * np.pi, (count - 1, 2))]
    plant = Plant(np.tile(true_parameters(config), (count, 1)), program.h, effects, phases)
    position, pwm = simulate(plant, control_constants(config), program.q)
    return [encode(q, u) for q, u in zip(position, pwm, strict=True)]


def main() -> None:
    """Run the benchmark and print its figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--config", type=Path, default=Path("config/config.yaml"))
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--arms", type=int, default=64)
    parser.add_argument("--repeats", type=int, default=5)
    args = parser.parse_args()
    config = load_config(args.config)
    e, h = config.experiment, config.signals.sampling_period_s
    around = e.lead_in_s + 2 * e.margin_samples * h
    program = program_from_config(changed(config, {"experiment": {"duration_s": args.seconds - around}}), "ID")
    alone, together = [], []
    for _ in range(args.repeats):  # in turn, so that both meet the same load
        began = time.process_time()
        one = capture(config, program)
        alone.append(time.process_time() - began)
        began = time.process_time()
        many = batch(config, program, args.arms)
        together.append(time.process_time() - began)
    if many[0] != one:
        raise RuntimeError("the first arm of the batch is not the one behind the board")
    n = program.q.shape[1]
    single, all_arms = float(np.median(alone)), float(np.median(together))
    each = all_arms / args.arms
    print(f"one arm behind its board: {single:.3f} s for {n} samples ({n * h:g} s), {1e6 * single / n:.0f} us a sample")
    print(f"batch of {args.arms}: {all_arms:.3f} s, {each:.4f} s an arm, {single / each:.1f} times cheaper")
    print(f"spread of the single captures: {min(alone):.3f} to {max(alone):.3f} s")


if __name__ == "__main__":
    main()
