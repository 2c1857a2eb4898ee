"""Many simulated arms: coverage of the network's intervals, spread of the similarity, verdict on the methods."""

import pandas as pd

from repro.exhibits.declare import EXPERIMENT, Inputs, figure, table
from repro.files import read_csv
from repro.identification.method import BASELINES
from repro.pipeline.job import Config
from repro.pipeline.monte_carlo import comparisons
from repro.render import coverage, experiment_tables, spread

SPREAD = ("case", "joint", "method", "duration", "arm", "chatter", "seed", "total")
RANKS = ("arms", "parameter", "level", "number", "known", "raw", "calibrated")
COVERAGE = ("arms", "parameter", "level", "raw", "calibrated", "factor", "width", "contraction", "warned")
INTERVALS = ("parameter", "true", "centre", "low", "high", "level", "warned")
#: Methods that the verdict compares with the baselines.
CONTENDERS = ("algorithm1", "algorithm1+tracked", "algorithm1+refinement", "algorithm1+local-search")
#: Methods of the figure; the literal Algorithm 1 would leave the others on one line.
DRAWN = ("algorithm1+tracked", "algorithm1+refinement", "least-squares", "bounded", "true")


def _spread(inputs: Inputs) -> pd.DataFrame:
    return pd.concat([read_csv(path, SPREAD) for path in inputs["scores"]], ignore_index=True)


@table(
    "coverage", "Do the intervals of the network cover", EXPERIMENT, coverage.table, inputs=("coverage",), trained="all"
)
def coverage_table(inputs: Inputs, _: Config) -> pd.DataFrame:
    """Shares of simulated arms whose true parameters lie in the intervals of the network of closed-loop motions, before
    and after calibration on other arms: on arms of Eq. 1, on arms with unmodelled torque, and on arms of another
    generator. The last row is for all nine parameters at once.
    """
    return read_csv(inputs["coverage"][0], COVERAGE)


@table(
    "intervals",
    "The arm's parameters with the network's intervals",
    EXPERIMENT,
    coverage.intervals,
    target="intervals",
    inputs=("coverage",),
    trained="all",
)
def intervals(inputs: Inputs, _: Config) -> pd.DataFrame:
    """Parameters of the simulated arm with the calibrated intervals of the network of tracked motions, and whether its
    recording is like the training motions.
    """
    return read_csv(inputs["intervals"][0], INTERVALS)


@figure(
    "coverage",
    "Levels at which intervals reach the truth",
    EXPERIMENT,
    coverage.figure,
    inputs=("coverage",),
    trained="all",
)
def coverage_figure(inputs: Inputs, _: Config) -> pd.DataFrame:
    """Calibration of the network's intervals on simulated arms with torque beyond Eq. 1: for each level, the share of
    arms whose true parameter the interval covers, minus the level. Dashed or solid lines are the range of the estimates
    from random guesses, and the interval calibrated on other arms. Zero is right, below is too narrow, above too wide.
    The band contains the whole line of a right one in 95 % of the cases.
    """
    return read_csv(inputs["ranks"][0], RANKS)


@table(
    "verdict",
    "Algorithm 1 against the field's methods",
    EXPERIMENT,
    experiment_tables.verdict,
    target="verdict",
    inputs=("spread",),
    trained="all",
)
def verdict(inputs: Inputs, _: Config) -> pd.DataFrame:
    """Algorithm 1, its variants and their control against least squares, plain, bounded and consistent, over many
    specimens of several simulated arms: in how many comparisons (motion and joint) each is better or worse, and by how
    much. Every comparison with its intervals is in the CSV.
    """
    return comparisons(_spread(inputs), CONTENDERS, tuple(BASELINES))


@figure("spread", "Similarity over many simulated arms", EXPERIMENT, spread.spread, inputs=("spread",), trained="all")
def spread_figure(inputs: Inputs, _: Config) -> pd.DataFrame:
    """Total similarity of every run of the simulated experiment, by motion, joint, method and duration of the
    identification trajectory; the bars are the medians over the seeds.
    """
    drawn = _spread(inputs).query("method in @DRAWN")[list(SPREAD)]
    median = drawn.groupby(["case", "joint", "method", "duration"])["total"].transform("median")
    return drawn.assign(median=median)
