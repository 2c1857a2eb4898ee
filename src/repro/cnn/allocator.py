"""Keep the allocator's big blocks: training frees and asks for the same megabytes at each step.

glibc returns them to the system and pays page faults for them in the next step, a third of the time. The workflow sets
the same limits by environment variables, which must be there before a process starts.
"""

import ctypes
import os

#: Numbers of glibc's mallopt, the variables that set the same, and values in bytes.
LIMITS = (
    (-3, "MALLOC_MMAP_THRESHOLD_", 2**25),
    (-1, "MALLOC_TRIM_THRESHOLD_", 2**31 - 1),
    (-2, "MALLOC_TOP_PAD_", 2**28),
)


def keep_blocks() -> bool:
    """Set the limits that the environment does not set.

    Returns
    -------
    bool
        Whether the allocator took them; False where it is not glibc's.
    """
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt is None:
        return False
    taken = [mallopt(number, value) for number, variable, value in LIMITS if variable not in os.environ]
    return all(taken)
