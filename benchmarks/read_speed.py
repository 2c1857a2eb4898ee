"""Reading guesses of one torque, and a whole search, against the plain way, on one thread.

The plain way reads by `FactoredCNN.forward`, which casts, lays out and multiplies again for every batch. Both take
turns in one process; ratios are of the shortest times. Without native bfloat16 leave it out, ``--precision float32``:
PyTorch then emulates it.
"""

import argparse
import os
import time
from pathlib import Path

from repro import contract

contract.hold(os.environ)

import numpy as np
import torch

from repro.cnn.image import ImageSettings, guess_factors, image_factors, torque_factors
from repro.cnn.network import load_network
from repro.cnn.reader import Reader
from repro.identification.algorithm1.preprocessing import filtered, prepare
from repro.identification.algorithm1.search import BATCH, ResidualEstimator, SearchSettings, search
from repro.logs.load import read_log
from repro.signals.dct import SignalSettings

ROOT = Path(__file__).resolve().parents[1]
#: Products of layers 1 to 4 of an image.
FLOP = 2 * (92 * 92 * 10 * 36 + 42 * 42 * 10 * 250 + 19 * 19 * 10 * 90 + 3610 * 100)


class Plain:
    """Lines 17 to 21 as they were before `Reader`."""

    def __init__(self, network, image, signals):
        self._network, self._image, self._alpha = network, image, signals.alpha.astype(np.float32)
        self._model = signals.model.reshape(-1, 9).T

    def estimate(self, guess):
        """Estimates (n, 9) from guesses."""
        return guess + np.concatenate([self._read(guess[k : k + BATCH]) for k in range(0, len(guess), BATCH)])

    def _read(self, guess):
        psi = 2 * self._alpha - (guess @ self._model).reshape(-1, *self._alpha.shape).astype(np.float32)
        u, v = image_factors(np.broadcast_to(self._alpha, psi.shape), psi, self._image)
        with torch.no_grad():
            return self._network(torch.from_numpy(u), torch.from_numpy(v[:1].copy())).numpy().astype(np.float64)


def shortest(works, repeats):
    """Shortest seconds of each of the works, which take turns."""
    times = np.full(len(works), np.inf)
    for _ in range(repeats):
        for k, work in enumerate(works):
            began = time.perf_counter()
            work()
            times[k] = min(times[k], time.perf_counter() - began)
    return times


def compare(precision, signals, repeats) -> None:
    """Print images/s, GFLOP/s and ratio of both ways, and how far their residuals differ."""
    network, image = load_network(ROOT / "data/networks/cnn.safetensors", precision=precision), ImageSettings()
    settings = SearchSettings(executions=BATCH, inner_limit=3, threshold=1.0)
    guess = np.random.default_rng(0).uniform(settings.low, settings.high, (BATCH, 9))
    alpha = signals.alpha.astype(np.float32)
    psi = (2 * alpha - np.einsum("jsp,np->njs", signals.model, guess)).astype(np.float32)
    v = torch.from_numpy(torque_factors(alpha, image))
    u = torch.from_numpy(guess_factors(psi, v.numpy(), image))
    reader, square = Reader(network, v), torch.randn(1024, 1024).to(network.dtype)
    ways = [way(network, image, signals) for way in (Plain, ResidualEstimator)]
    works = {
        "network": [lambda: network(u, v[None]), lambda: reader(u)],
        "estimate": [lambda way=way: way.estimate(guess) for way in ways],
        "search": [lambda way=way: search(way, signals, settings, np.random.default_rng(1)) for way in ways],
    }
    rate = 2 * 1024**3 / shortest([lambda: torch.mm(square, square)], 5)[0]
    difference = float((network(u, v[None]) - reader(u)).abs().max())
    print(f"{precision}: matrix rate {rate / 1e9:.0f} GFLOP/s; residuals differ by {difference:.1e} at most")
    for name, pair in works.items():
        images = BATCH * (settings.inner_limit if name == "search" else 1)
        plain, fast = images / shortest(pair, repeats)
        speeds = ", ".join(f"{x:.0f} images/s ({FLOP * x / 1e9:.0f} GFLOP/s)" for x in (plain, fast))
        print(f"  {name:<9}{speeds}, ratio {fast / plain:.2f}")


def main() -> None:
    """Compare on the recording ID that comes with the project."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--precision", nargs="+", default=["float32", "bfloat16"])
    parser.add_argument("--repeats", type=int, default=30)
    args = parser.parse_args()
    torch.set_num_threads(1)
    run, signals = read_log(ROOT / "data/captures/ID.bin"), SignalSettings()
    recorded = filtered(run.q, run.tau, signals, 340, 4110)
    for precision in args.precision:
        compare(precision, prepare(recorded, recorded.tau, signals), args.repeats)


if __name__ == "__main__":
    main()
