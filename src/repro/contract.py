"""The numeric contract: which instructions linear algebra may use, so that processors agree to the last bit.

OpenBLAS and NumPy pick kernels for the processor they find, and kernels add in different orders. Held to what every
x86-64-v3 processor has (AVX2 and FMA), on one thread, they give the same bits on all of them. PyTorch is not held: its
float32 products would take two to three times as long, those in bfloat16 eighty times; what hangs on a network agrees
within the spread over training seeds instead (`repro.comparison`).
"""

import platform
import sys
from collections.abc import Mapping, MutableMapping
from pathlib import Path

CPUINFO = Path("/proc/cpuinfo")
#: Variables that NumPy and OpenBLAS read when they are loaded.
CONTRACT = {"OPENBLAS_CORETYPE": "Haswell", "NPY_DISABLE_CPU_FEATURES": "X86_V4 AVX512_ICL AVX512_SPR"}
#: Of any processor: sums do not depend on how many cores there are.
ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1"}
#: Flags of x86-64-v3 that the contract's kernels use.
NEEDED = {"avx2", "fma", "bmi1", "bmi2", "f16c", "movbe"}
#: Kernels of OpenBLAS that end a process with an illegal instruction where the processor has no AVX-512.
AVX512_KERNELS = {"skylakex", "cooperlake", "sapphirerapids"}


def _flags(cpuinfo: Path) -> set[str]:
    """Flags of this processor; none where they cannot be determined."""
    if platform.machine() not in ("x86_64", "AMD64") or not cpuinfo.exists():
        return set()
    return set(next((line for line in cpuinfo.read_text().splitlines() if line.startswith("flags")), "").split())


def is_v3(cpuinfo: Path = CPUINFO) -> bool:
    """Whether this processor has the instructions of x86-64-v3; False where that cannot be determined."""
    return _flags(cpuinfo) >= NEEDED


def can_run(kernel: str, cpuinfo: Path = CPUINFO) -> bool:
    """Whether this processor has the instructions of a kernel of OpenBLAS; True where that cannot be determined."""
    flags = _flags(cpuinfo)
    return kernel.lower() not in AVX512_KERNELS or not flags or "avx512vl" in flags


def set_variables(environment: MutableMapping[str, str]) -> list[str]:
    """Set the variables of the contract that the user has not set, for processes to come; the names that were set.

    A kernel that this processor cannot run counts as not set.
    """
    wanted = ONE_THREAD | (CONTRACT if is_v3() else {})
    if not can_run(environment.get("OPENBLAS_CORETYPE", "")):
        del environment["OPENBLAS_CORETYPE"]
    missing = [name for name in wanted if name not in environment]
    environment.update((name, wanted[name]) for name in missing)
    return missing


def hold(environment: MutableMapping[str, str]) -> None:
    """Hold this process to the contract, except where the user has set a variable."""
    late = set_variables(environment)
    if late and "numpy" in sys.modules:
        raise RuntimeError(f"contract: {', '.join(late)} must be set before numpy is loaded.")


def held(environment: Mapping[str, str]) -> dict[str, str]:
    """The variables of the contract as they stand, for the record of a run."""
    return {name: environment.get(name, "") for name in ONE_THREAD | CONTRACT}
