"""What each pin of a numeric contract costs: times of single operations under it, over those without any, one thread.

Every pin is a process of its own, since libraries read the variables when they are loaded; each time is the best of
many, so that other work on the machine shows little.
"""

import json
import os
import subprocess
import sys
import time

from repro.contract import CONTRACT, ONE_THREAD

PINS = {
    "nothing": {},
    "OPENBLAS_CORETYPE": {"OPENBLAS_CORETYPE": CONTRACT["OPENBLAS_CORETYPE"]},
    "NPY_DISABLE_CPU_FEATURES": {"NPY_DISABLE_CPU_FEATURES": CONTRACT["NPY_DISABLE_CPU_FEATURES"]},
    "ATEN_CPU_CAPABILITY": {"ATEN_CPU_CAPABILITY": "avx2"},
    "MKL_CBWR": {"MKL_CBWR": "COMPATIBLE"},
    "ONEDNN_MAX_CPU_ISA": {"ONEDNN_MAX_CPU_ISA": "AVX2"},
}
REPEATS = 15


def best(function, inner):
    """Best time of a call, s."""
    times = []
    for _ in range(REPEATS):
        began = time.perf_counter()
        for _ in range(inner):
            function()
        times.append((time.perf_counter() - began) / inner)
    return min(times)


def measure():
    """Times of this process, s, by operation."""
    import numpy as np  # noqa: PLC0415 - under the pins of this process
    import torch  # noqa: PLC0415

    torch.set_num_threads(1)
    rng = np.random.default_rng(0)
    y, tau, square, x = (
        rng.normal(size=(7540, 9)),
        rng.normal(size=7540),
        rng.normal(size=(512, 512)),
        rng.normal(size=10**5),
    )
    a, images = torch.randn(1024, 1024), torch.randn(64, 10, 46, 46).contiguous(memory_format=torch.channels_last)
    half, kernel = a.bfloat16(), torch.randn(10, 10, 5, 5)
    return {
        "least squares 7540 x 9": best(lambda: np.linalg.lstsq(y, tau), 3),
        "product 512 x 512": best(lambda: square @ square, 3),
        "exp of 100,000": best(lambda: np.exp(x), 10),
        "torch product 1024": best(lambda: a @ a, 1),
        "the same in bfloat16": best(lambda: half @ half, 1),
        "torch convolution": best(lambda: torch.nn.functional.conv2d(images, kernel), 1),
        "torch sigmoid": best(lambda: torch.sigmoid(a), 3),
    }


def main():
    """Print the table, or the times of this process if asked by the one that prints it."""
    if len(sys.argv) > 1:
        print(json.dumps(measure()))
        return
    clean = {k: v for k, v in os.environ.items() if k not in {name for pin in PINS.values() for name in pin}}
    times = {}
    for name, pin in PINS.items():
        command = [sys.executable, __file__, "child"]
        done = subprocess.run(command, env=clean | ONE_THREAD | pin, capture_output=True, text=True, check=True)
        times[name] = json.loads(done.stdout)
    operations = list(times["nothing"])
    print("| pinned |", " | ".join(operations), "|")
    print("|---|" + "---|" * len(operations))
    print("| nothing, ms |", " | ".join(f"{1e3 * times['nothing'][o]:.3g}" for o in operations), "|")
    for name in list(PINS)[1:]:
        print(f"| {name} |", " | ".join(f"x {times[name][o] / times['nothing'][o]:.2f}" for o in operations), "|")


if __name__ == "__main__":
    main()
