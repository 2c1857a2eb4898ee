"""Training on two cores in company: ms a step with one and two threads, of one and two networks, beside busy processes.

Each network and each busy process is a process of its own; all networks of a row start together and do the same steps.
"""

import argparse
import os
import subprocess
import sys
import time

from repro import contract

contract.hold(os.environ)

from repro.experiments.job import set_allocator

#: Networks, threads of each, busy processes beside them.
ROWS = ((1, 2, 0), (1, 1, 0), (2, 1, 0), (1, 2, 1), (1, 1, 1), (2, 1, 1), (1, 1, 2), (2, 1, 2))


def train(steps, threads):
    """Milliseconds a step of this process."""
    import torch  # noqa: PLC0415

    from repro.cnn.architecture import NetworkSettings, TrainingSettings  # noqa: PLC0415
    from repro.cnn.dataset import DataSettings, sample_motion  # noqa: PLC0415
    from repro.cnn.train import train as run  # noqa: PLC0415
    from repro.signals.dct import SignalSettings  # noqa: PLC0415
    from repro.signals.trajectories import identification_trajectory  # noqa: PLC0415

    torch.set_num_threads(threads)
    signals = SignalSettings()
    motion = sample_motion(identification_trajectory(signals.duration_s, signals.sampling_period_s), signals)

    def took(n):
        began = time.perf_counter()
        run(motion, DataSettings(), NetworkSettings(), TrainingSettings(steps=n, test_samples=1, log_every=n))
        return time.perf_counter() - began

    took(10)
    print(1e3 * took(steps) / steps)


def measure(steps, networks, threads, busy):
    """Slowest network's milliseconds a step."""
    spinners = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(busy)]
    command = [sys.executable, __file__, "--child", str(threads), "--steps", str(steps)]
    try:
        running = [subprocess.Popen(command, stdout=subprocess.PIPE, text=True) for _ in range(networks)]
        return max(float(each.communicate()[0]) for each in running)
    finally:
        for each in spinners:
            each.kill()


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--steps", type=int, default=150)
    parser.add_argument("--child", type=int, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.child:
        train(arguments.steps, arguments.child)
        return
    set_allocator(os.environ)
    print("| networks | threads each | busy processes beside | ms a step | ms a step of all |\n|---|---|---|---|---|")
    for networks, threads, busy in ROWS:
        slowest = measure(arguments.steps, networks, threads, busy)
        print(f"| {networks} | {threads} | {busy} | {slowest:.0f} | {slowest / networks:.0f} |", flush=True)


if __name__ == "__main__":
    main()
