"""Streams of random numbers: every use of a seed draws from one of its own."""

from enum import IntEnum, unique

import numpy as np


@unique
class Stream(IntEnum):
    """What a seed's random numbers are for. None is 0, see `stream`."""

    TRAIN_STEP = 1
    TEST_SET = 2
    FIXED_SET = 3
    SEARCH = 4
    REFINE = 5
    VALIDATION = 6
    TRAINING_ARMS = 7  # of Figure 9, whose mean gives the mean training torque
    EXAMPLES = 8
    RANDOM_MOTION = 10  # T1
    EXPERIMENT_SEARCH = 11
    EXPERIMENT_REFINE = 12
    OWN_SEARCH = 14
    OWN_REFINE = 15
    OWN_BOOTSTRAP = 16
    TRACKED_ARMS = 17
    COVERAGE_ARMS = 20
    COVERAGE_GUESSES = 21
    SELF_TEST = 22
    PLAIN_STEP = 23
    FACTORIAL_SEARCH = 24
    UNIFORM_SEARCH = 25
    STUDY_MOTION = 26
    STUDY_ARMS = 27
    STUDY_EFFECTS = 28
    STUDY_TRAINING_ARMS = 29
    STUDY_SEARCH = 30
    STUDY_FLOW = 31
    STUDY_VALIDATION = 32  # T1
    STUDY_LAW = 33
    MATCHING = 34
    LONG_SEARCH = 35


# NumPy mixes a seed in words of 32 bits: a larger number fills two and could be taken for two numbers.
_WORD = 2**32


def stream(seed: int, name: Stream, *index: int) -> np.random.Generator:
    """Generator of one use of a seed.

    NumPy pads a short sequence of seeds with zeros, so that (seed, 1) and (seed, 1, 0) give the same numbers. One
    is added to each index: no sequence ends in a zero, so none is another one padded.
    """
    words = (seed, int(name), *(k + 1 for k in index))
    if not (0 <= seed < _WORD and all(0 < word < _WORD for word in words[1:])):
        raise ValueError(f"seed, index: must be at least 0 and fit in 32 bits, got {seed} and {index}.")
    return np.random.default_rng(words)
