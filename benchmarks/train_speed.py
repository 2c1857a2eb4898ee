"""Plain against factored training, interleaved in one process: time a step, ratio, share of the matrix rate, loss."""

import argparse
import os
import sys
import time
from pathlib import Path

from repro import contract

contract.hold(os.environ)

from repro.experiments.job import ALLOCATOR, set_allocator

if any(name not in os.environ for name in ALLOCATOR):  # glibc reads them when a process starts
    set_allocator(os.environ)
    os.execv(sys.executable, [sys.executable, *sys.argv])

import numpy as np
import torch

from repro.cnn.architecture import NetworkSettings, TrainingSettings
from repro.cnn.dataset import DataSettings, draw_samples, sample_motion
from repro.cnn.image import assemble
from repro.cnn.network import FactoredCNN, sigmoid_loss
from repro.cnn.train import streamed_schedule
from repro.signals.dct import SignalSettings
from repro.signals.trajectories import identification_trajectory

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests/examples"))
from literal import SignalCNN

#: Steps a network takes in a row, so that each works from its own cache.
BLOCK = 10


def matrix_rate(dtype: torch.dtype, side: int = 1024) -> float:
    """Best of ten square products, FLOP/s."""
    a, b = (torch.randn(side, side).to(dtype) for _ in range(2))
    best = min(_seconds(lambda: a @ b) for _ in range(10))
    return 2 * side**3 / best


def _seconds(work) -> float:
    began = time.perf_counter()
    work()
    return time.perf_counter() - began


def step_flop(batch: int, still: bool) -> float:
    """Products that a factored step cannot avoid: forward and twice that backward, once in layer 1.

    Where layer 1 is still, forward alone there and once backward in layer 2.
    """
    layer1 = 92 * 92 * 10 * 36 * 2
    layer2 = 42 * 42 * 10 * 250 * 2
    rest = 19 * 19 * 10 * 90 * 2 + 3610 * 100 * 2
    return batch * ((2 - still) * layer1 + (3 - still) * layer2 + 3 * rest)


def main() -> None:
    """Run the benchmark and print its table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--steps", type=int, default=400)
    parser.add_argument("--batch", type=int, default=64)
    parser.add_argument("--threads", type=int, default=2)
    args = parser.parse_args()
    torch.set_num_threads(args.threads)
    motion = sample_motion(identification_trajectory(), SignalSettings())
    sizes = NetworkSettings()
    settings = TrainingSettings(steps=args.steps, batch=args.batch, warmup=args.steps // 10, test_samples=1)
    runs = {"plain float32": SignalCNN(sizes)}
    runs |= {f"factored {p}": FactoredCNN(sizes, p) for p in ("float32", "bfloat16")}
    runs["factored bfloat16 still"] = FactoredCNN(sizes, "bfloat16")  # as in most steps of the schedule
    runs["factored bfloat16 still"].conv1.requires_grad_(False)
    for network in runs.values():
        network.load_state_dict(runs["plain float32"].state_dict())
    runs["plain float32"].dtype = torch.float32  # of Muon's wide products
    schedules = {name: streamed_schedule(network, motion, DataSettings(), settings) for name, network in runs.items()}
    seconds = {name: [] for name in runs}

    def inputs(name, samples):
        if name.startswith("plain"):
            return (torch.from_numpy(assemble(samples.u, samples.v)),)
        return torch.from_numpy(samples.u), torch.from_numpy(np.array(samples.v))

    for block in range(0, args.steps, BLOCK):
        batches = [
            draw_samples(np.random.default_rng((1, step)), args.batch, motion, DataSettings())
            for step in range(block, min(block + BLOCK, args.steps))
        ]
        for name, network in runs.items():
            for step, samples in enumerate(batches, block):
                for group in (g for o in schedules[name].optimisers for g in o.param_groups):
                    group["lr"] = schedules[name].rate(step)
                label, ready = torch.from_numpy(samples.residual), inputs(name, samples)
                began = time.perf_counter()  # building images is not charged to the plain network
                network.zero_grad()
                sigmoid_loss(network(*ready), label, 1.0).backward()
                for optimiser in schedules[name].optimisers:
                    optimiser.step()
                seconds[name].append(time.perf_counter() - began)
    test = [draw_samples(np.random.default_rng((2, k)), 64, motion, DataSettings()) for k in range(32)]
    rate = {"float32": matrix_rate(torch.float32), "bfloat16": matrix_rate(torch.bfloat16)}
    print("matrix rate: " + ", ".join(f"{r / 1e9:.0f} GFLOP/s {p}" for p, r in rate.items()))
    plain = np.median(seconds["plain float32"])
    print(f"{'network':<24}{'ms a step':>10}{'images/s':>10}{'ratio':>7}{'of matrix rate':>16}{'held-out loss':>15}")
    for name, times in seconds.items():
        median = float(np.median(times))
        share = step_flop(args.batch, name.endswith("still")) / median / rate[name.split()[1]]
        shown = f"{share:15.0%} " if name.startswith("factored") else f"{'-':>15} "
        with torch.no_grad():
            losses = [
                sigmoid_loss(runs[name](*inputs(name, part)), torch.from_numpy(part.residual), 1.0) for part in test
            ]
        loss = float(torch.stack(losses).mean())
        print(f"{name:<24}{1e3 * median:10.1f}{args.batch / median:10.0f}{plain / median:7.2f}{shown}{loss:15.2e}")


if __name__ == "__main__":
    main()
