"""Answers of the study: differences of methods with intervals over arms, claims of the paper, and calibration."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from repro.experiments.monte_carlo import EQUIVALENT, FAMILY_LEVEL, OPEN, conclude, interval
from repro.model.parameters import Array
from repro_studies.design import ALGORITHM1, FACTORS, FLOW, KEYS, NETWORKS, POSTERIOR, RANKS, TRACKED, TRAINED_ON

#: Pairs of methods that are compared in every cell, first minus second.
PAIRS = (
    (ALGORITHM1, "ordinary"), (ALGORITHM1, "consistent"), (TRACKED, "consistent"),
    (POSTERIOR, "ordinary"), (POSTERIOR, "consistent"), (POSTERIOR, "generalised+prior"), (FLOW, POSTERIOR),
    ("generalised+prior", "consistent"), ("generalised", "consistent"),
)  # fmt: skip
#: Central interval whose coverage is stated.
LEVEL = 0.95


def difference(outcomes: pd.DataFrame, method: str, opponent: str) -> pd.Series:
    """Similarity of a method minus that of another, by the factors and the arm; only where both were run."""
    if outcomes.duplicated(list(KEYS)).any():
        raise ValueError("outcomes: a method has two rows for one arm of a cell.")
    values = outcomes.set_index(list(KEYS))["validation"]
    names = values.index.get_level_values("method")
    first, second = (values[names == name].droplevel("method") for name in (method, opponent))
    return (first - second).dropna()


def conditions(values: pd.Series) -> pd.DataFrame:
    """Centre and interval over the arms in each condition, valid at once in all of them, and what follows."""
    names = [name for name in values.index.names if name != "arm"]
    cells, rows = values.groupby(names, sort=False), []
    for cell, own in cells:
        centre, low, high = interval(own.to_numpy(), 1.0 - FAMILY_LEVEL / cells.ngroups)
        rows.append((*cell, len(own), centre, low, high, conclude(low, high, (low > 0) - (high < 0))))
    return pd.DataFrame(rows, columns=[*names, "arms", "difference", "low", "high", "conclusion"])


def maps(outcomes: pd.DataFrame) -> pd.DataFrame:
    """Every pair of methods in every condition; `mean` and `sure` are of its square of the map, over all frictions."""
    tables = {pair: table for pair in PAIRS if len(table := conditions(difference(outcomes, *pair)))}
    table = pd.concat(tables, names=["method", "opponent"]).reset_index(["method", "opponent"])
    square = ["method", "opponent", *(factor for factor in FACTORS if factor != "friction")]
    groups = table.assign(sure=(table["low"] > 0.0) | (table["high"] < 0.0)).groupby(square)
    mean, sure = groups["difference"].transform("mean"), groups["sure"].transform("sum")
    return table.assign(mean=mean, sure=sure, of=groups["sure"].transform("size"))


@dataclass(frozen=True)
class Claim:
    """A sentence, and the difference that is positive if it is true; one value for each arm and friction."""

    name: str
    sentence: str
    values: Callable[[pd.DataFrame], pd.Series]
    margin: float = 0.0  # by which the difference may be negative


def _effect(values: pd.Series, factor: str, first: object, second: object) -> pd.Series:
    """Difference between two levels of a factor, by prior and arm, in an additive model of all factors."""
    effects = {}
    for prior, own in values.groupby("prior"):
        arms = own.unstack("arm")
        levels = pd.get_dummies(arms.index.to_frame(), columns=arms.index.names, dtype=np.float64)
        contrast = 1.0 * (levels.columns == f"{factor}_{first}") - (levels.columns == f"{factor}_{second}")
        weights = np.linalg.pinv(levels.T) @ contrast
        if contrast.any() and np.allclose(levels.T @ weights, contrast):  # else the conditions do not determine it
            effects[prior] = pd.Series(weights @ arms.to_numpy(), arms.columns)
    return pd.concat(effects, names=["prior"]).dropna() if effects else values.iloc[:0]


def _optimised(outcomes: pd.DataFrame) -> pd.Series:
    """Algorithm 1 identified by Eq. 10 minus identified by the D-optimal motion."""
    values = outcomes[outcomes["method"] == ALGORITHM1].set_index([*FACTORS, "arm"])["validation"]
    return _effect(values, "excitation", "eq10", "optimal")


def _robust(outcomes: pd.DataFrame) -> pd.Series:
    """What the largest discrepancy costs ordinary least squares minus what it costs Algorithm 1."""
    levels = outcomes["discrepancy"]
    return _effect(difference(outcomes, ALGORITHM1, "ordinary"), "discrepancy", levels.min(), levels.max())


#: Claims of the paper, and the question of the study; fixed before the first full run.
CLAIMS = (
    Claim("better", "Algorithm 1 is better than least squares", lambda of: difference(of, ALGORITHM1, "ordinary")),
    Claim("unoptimised", "no trajectory optimisation is needed", _optimised, EQUIVALENT),
    Claim(
        "identical",
        "it is not critical that the trajectory be identical to that of the training",
        lambda of: difference(of[of["excitation"] == "eq10"], ALGORITHM1, TRACKED),
        EQUIVALENT,
    ),
    Claim("robust", "Algorithm 1 loses less than least squares where Eq. 1 does not hold", _robust),
    Claim(
        "posterior",
        "the amortised posterior is better than least squares",
        lambda of: difference(of, POSTERIOR, "ordinary"),
    ),
    Claim(
        "constrained",
        "the amortised posterior is better than consistent least squares",
        lambda of: difference(of, POSTERIOR, "consistent"),
    ),
    Claim(
        "prior",
        "generalised least squares with the prior is better than consistent least squares",
        lambda of: difference(of, "generalised+prior", "consistent"),
    ),
)


def _slow(outcomes: pd.DataFrame) -> pd.Series:
    """Gain of the posterior with the narrow prior by the slow motion minus its mean gain by the others."""
    gain = difference(outcomes[outcomes["prior"] == "narrow"], POSTERIOR, "consistent")
    slow = gain.index.get_level_values("excitation") == "slow"
    first, others = (own.groupby(["prior", "arm"]).mean() for own in (gain[slow], gain[~slow]))
    return (first - others).dropna()


def _uncovered(outcomes: pd.DataFrame) -> pd.Series:
    """By how much the share of parameters in the posterior's intervals is less than it should be."""
    own = outcomes[(outcomes["method"] == POSTERIOR) & (outcomes["discrepancy"] == outcomes["discrepancy"].min())]
    inside = (own.set_index([*FACTORS, "arm"])[list(RANKS)] - 0.5).abs() < LEVEL / 2
    uncovered: pd.Series = LEVEL - inside.mean(axis=1)
    return uncovered


#: What was expected before the first full run, numbered as it was written down.
EXPECTATIONS = (
    Claim("1", "Algorithm 1 is worse than least squares", lambda of: difference(of, "ordinary", ALGORITHM1)),
    Claim("2", "the posterior is better than Algorithm 1", lambda of: difference(of, POSTERIOR, ALGORITHM1)),
    Claim(
        "3",
        "it is better than least squares at the largest discrepancy",
        lambda of: difference(of[of["discrepancy"] == of["discrepancy"].min()], POSTERIOR, "ordinary"),
    ),
    Claim(
        "3",
        "it is not better than consistent least squares with the wide prior",
        lambda of: difference(of[of["prior"] == "wide"], "consistent", POSTERIOR),
        EQUIVALENT,
    ),
    Claim(
        "4",
        "with the narrow prior it is better",
        lambda of: difference(of[of["prior"] == "narrow"], POSTERIOR, "consistent"),
    ),
    Claim("4", "this gain is largest on the slow motion", _slow),
    Claim(
        "5",
        "generalised least squares with the prior is at least as good where the prior is right",
        lambda of: difference(of[of["prior"] != "mismatched"], "generalised+prior", POSTERIOR),
        EQUIVALENT,
    ),
    Claim("6", "Algorithm 1 is better by the D-optimal motion than by Eq. 10", lambda of: -_optimised(of)),
    Claim("7", "95 % intervals of the posterior cover less at the largest discrepancy", _uncovered),
)


def training_spread(outcomes: pd.DataFrame, method: str) -> tuple[float, int]:
    """Standard deviation of a method's mean from network to network, and its degrees of freedom; NaN where it has none.

    There is one network for each motion and law of the training. Their gains on consistent least squares are fitted by
    effects of motion and law, and the residual is the spread. So the interaction of both counts as training.
    """
    gain = difference(outcomes, method, "consistent")
    law = gain.index.get_level_values("prior").map(TRAINED_ON)
    means = gain.groupby([law, gain.index.get_level_values("excitation")]).mean().unstack().to_numpy()
    rest = means - means.mean(axis=1, keepdims=True) - means.mean(axis=0) + means.mean()
    free = (means.shape[0] - 1) * (means.shape[1] - 1)
    return (float(np.sqrt((rest**2).sum() / free)), free) if free else (np.nan, 0)


def _training_half_width(claim: Claim, outcomes: pd.DataFrame, half_widths: Mapping[str, float]) -> float:
    """Half width of the interval of a claim's mean, from those of one network of each method."""
    one = outcomes[outcomes["arm"] == outcomes["arm"].min()].reset_index(drop=True)  # weights are those of any arm
    mean, square = claim.values(one).mean(), 0.0
    for (method, _, _), own in one.groupby(["method", one["prior"].map(TRAINED_ON), "excitation"]):
        if method in half_widths:
            moved = one.assign(validation=one["validation"] + one.index.isin(own.index))
            weight = claim.values(moved).mean() - mean
            if abs(weight) > 1e-9:  # else a half width that is not known does not matter
                square += (weight * half_widths[str(method)]) ** 2
    return float(np.sqrt(square))


def claims(outcomes: pd.DataFrame, chosen: Sequence[Claim] = CLAIMS) -> pd.DataFrame:
    """Each claim whose levels were run: its centre, intervals that are valid at once for all claims, its conditions.

    The first interval is over arms, for these networks. The verdict follows from the second, which adds the spread
    between trainings of the similarity.
    """
    from scipy import stats  # noqa: PLC0415 (a quarter of a second, in each job that reads the workflow)

    rows, level = [], 1.0 - FAMILY_LEVEL / len(chosen)
    spreads = {name: training_spread(outcomes, name) for name in NETWORKS if (outcomes["method"] == name).any()}
    half_widths = {name: spread * stats.t.ppf(0.5 + 0.5 * level, free) for name, (spread, free) in spreads.items()}
    for claim in chosen:
        values = claim.values(outcomes)
        if values.empty:
            continue
        of_arms = values.groupby(["prior", "arm"]).mean()
        centre, low, high = interval(of_arms.to_numpy(), level)
        half = _training_half_width(claim, outcomes, half_widths)
        least, most = centre - float(np.hypot(centre - low, half)), centre + float(np.hypot(high - centre, half))
        verdict = "holds" if least > -claim.margin else "fails" if most < -claim.margin else OPEN
        sure = conditions(values)["low"] > 0
        found = (claim.name, claim.sentence, len(of_arms), centre, low, high, least, most, claim.margin, verdict)
        rows.append((*found, int(sure.sum()), len(sure)))
    columns = ["claim", "sentence", "arms", "difference", "low", "high", "least", "most", "margin", "verdict"]
    return pd.DataFrame(rows, columns=[*columns, "better", "conditions"])


def levels(outcomes: pd.DataFrame) -> pd.DataFrame:
    """Claims on each condition, by the levels of each factor: mean difference, how many are surely true or false."""
    rows = []
    for claim in CLAIMS:
        values = claim.values(outcomes)
        if not {*FACTORS} <= {*values.index.names} or values.empty:
            continue
        found = conditions(values)
        for factor in FACTORS:
            for level, own in found.groupby(factor, sort=False):
                sure = int((own["low"] > 0).sum()), int((own["high"] < 0).sum())
                rows.append((claim.name, factor, level, own["difference"].mean(), *sure, len(own)))
    columns = ["claim", "factor", "level", "difference", "better", "worse", "conditions"]
    return pd.DataFrame(rows, columns=columns)


def means(outcomes: pd.DataFrame) -> pd.DataFrame:
    """Mean outcomes of each method by prior over the conditions of all methods; medians of what has no bound."""
    counts = outcomes.groupby(list(FACTORS))["method"].transform("nunique")
    common = outcomes[counts == outcomes["method"].nunique()].copy()
    inside = (common[list(RANKS)] - 0.5).abs() < LEVEL / 2
    common["covered"] = inside.mean(axis=1).where(common[RANKS[0]].notna())
    of = dict.fromkeys(("id", "validation", "torque_error", "parameter_error", "covered"), "mean")
    of |= dict.fromkeys(("position_error", "contraction"), "median")
    table: pd.DataFrame = common.groupby(["prior", "method"], sort=False).agg(of).reset_index()
    return table


def calibration(outcomes: pd.DataFrame) -> pd.DataFrame:
    """Distribution of the probability below the truth and of the nearer share, by method and prior, with a band.

    Both are uniform where a claimed distribution is right. The band is for as many independent values as arms.
    """
    grid, rows = np.linspace(0.0, 1.0, 41), []
    claimed = outcomes[outcomes[RANKS[0]].notna()]
    for (prior, method), own in claimed.groupby(["prior", "method"], sort=False):
        half = band(own["arm"].nunique(), grid)
        for what, columns in (("each", RANKS), ("together", ("nearer",))):
            shares = (own[list(columns)].to_numpy()[..., np.newaxis] <= grid).mean(axis=(0, 1))
            rows += [(prior, method, what, x, y, half) for x, y in zip(grid, shares, strict=True)]
    return pd.DataFrame(rows, columns=["prior", "method", "of", "level", "share", "band"])


def band(n: int, grid: Array) -> float:
    """Half width of a band about the diagonal that contains the distribution of n uniform numbers with 95 %."""
    uniform = np.random.default_rng(0).uniform(size=(2000, n))
    apart = np.abs((uniform[..., np.newaxis] <= grid).mean(axis=1) - grid).max(axis=1)
    return float(np.quantile(apart, LEVEL))
