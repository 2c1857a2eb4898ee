"""Differences, claims and calibration, on outcomes made by hand."""

import numpy as np
import pandas as pd
import pytest
from scipy import stats
from study_example import outcomes

from repro.experiments.monte_carlo import EQUIVALENT, OPEN
from repro_studies import analysis
from repro_studies.design import RANKS


def test_each_pair_is_compared_in_each_cell_and_a_square_of_the_map_is_over_its_frictions():
    sure, unsure = outcomes({"wide": -0.03, "narrow": 0.05}), outcomes({"wide": 0.01, "narrow": 0.01}, seed=9)
    frictions = [sure.assign(friction=0.5), sure.assign(friction=1.0), unsure.assign(friction=3.0)]
    table = analysis.maps(pd.concat(frictions, ignore_index=True))
    assert len(table) == len(analysis.PAIRS) * 8 * 3
    pair = table[(table["method"] == "posterior") & (table["opponent"] == "consistent")]
    assert pair[["sure", "of"]].drop_duplicates().to_numpy().tolist() == [[2, 3]]
    for prior, difference, conclusion in (("narrow", 0.04, "better"), ("wide", -0.04, "worse")):
        own = pair[pair["prior"] == prior]
        assert own["mean"].to_numpy() == pytest.approx([2 / 3 * difference] * 12, abs=0.002)
        steady = own[own["friction"] < 3.0]
        assert steady["difference"].to_numpy() == pytest.approx([difference] * 8, abs=0.002)
        assert set(steady["conclusion"]) == {conclusion}


def test_claims_have_the_sign_of_what_they_say():
    """Algorithm 1 is run in other discrepancies of either motion, of which the comparison of motions is adjusted."""
    frame = outcomes({"wide": 0.03, "narrow": 0.05})
    own, hard = frame["method"].str.startswith("algorithm1"), frame["discrepancy"] == 0.9
    frame.loc[own & hard, "validation"] -= 0.06
    table = analysis.claims(frame[~(own & hard & (frame["excitation"] == "optimal"))]).set_index("claim")
    differences = {"better": -0.12, "posterior": 0.04, "robust": -0.06, "unoptimised": 0.0, "identical": 0.0}
    own = table.loc[[*differences]]
    assert own["difference"].to_dict() == pytest.approx(differences, abs=0.002)
    assert own["verdict"].tolist() == ["fails", "holds", "fails", "holds", "holds"]  # the last two within the margin
    assert table.loc[["posterior", "better"], ["better", "conditions"]].to_numpy().tolist() == [[8, 8], [0, 6]]
    assert table["arms"].tolist() == [24] * len(table)
    assert "unoptimised" not in [*analysis.claims(frame[hard == (frame["excitation"] == "eq10")])["claim"]]


def test_expectations_have_the_sign_of_what_they_say():
    frame = outcomes({"wide": 0.03, "narrow": 0.05}).replace({"excitation": {"eq10": "slow"}})
    slow, own = frame["excitation"] == "slow", frame["method"] == "posterior"
    frame.loc[slow & own, "validation"] += 0.02
    narrow = own & (frame["discrepancy"] == 0.9)
    frame.loc[narrow, list(RANKS)] = 0.5 + 1.2 * (frame.loc[narrow, list(RANKS)] - 0.5)
    table = analysis.claims(frame, analysis.EXPECTATIONS)
    assert table["claim"].tolist() == ["1", "2", "3", "3", "4", "4", "5", "7"]  # Eq. 10 is missing for the sixth
    *differences, uncovered = table["difference"]
    assert differences == pytest.approx([0.1, 0.15, 0.05, -0.03, 0.05, 0.02, -0.03], abs=0.003)
    assert uncovered == pytest.approx(0.95 - 0.95 / 1.2, abs=0.06)
    assert table["verdict"].tolist() == ["holds", "holds", "holds", "fails", "holds", "holds", "fails", "holds"]


def test_the_spread_between_trainings_is_what_effects_of_motion_and_law_leave():
    """Gains by motion and law are 0.1 + motion + law and a network's deviation, which has no row or column mean."""
    deviations = {
        ("wide", "eq10"): 0.03,
        ("narrow", "eq10"): -0.03,
        ("wide", "optimal"): -0.03,
        ("narrow", "optimal"): 0.03,
    }
    frame = outcomes({"wide": 0.03, "narrow": 0.05})
    assert analysis.training_spread(frame, "algorithm1") == pytest.approx((0.0, 1), abs=1e-12)
    own = frame["method"] == "algorithm1"
    networks = pd.MultiIndex.from_frame(frame.loc[own, ["prior", "excitation"]])
    frame.loc[own, "validation"] += (
        networks.map(deviations) + 0.2 * networks.isin(["wide"], 0) + 0.1 * networks.isin(["eq10"], 1)
    )
    assert analysis.training_spread(frame, "algorithm1") == pytest.approx((2 * 0.03, 1))  # root of four squares
    assert analysis.training_spread(frame[frame["excitation"] == "eq10"], "algorithm1")[1] == 0


def test_a_claim_on_few_networks_that_scatter_is_open_though_all_arms_agree():
    frame = outcomes({"wide": 0.03, "narrow": 0.05})
    own, optimal = frame["method"] == "algorithm1", frame["excitation"] == "optimal"
    frame.loc[own & optimal, "validation"] -= frame.loc[own & optimal, "prior"].map({"wide": 0.35, "narrow": 0.15})
    table = analysis.claims(frame).set_index("claim")
    row, level = table.loc["unoptimised"], 1.0 - 0.05 / len(analysis.CLAIMS)
    assert row["low"] > 0.14 and row["verdict"] == OPEN and row["least"] < 0.0
    # Each of two motions has two networks: (1/2 + 1/2)^(1/2) times the spread 0.1, with one degree of freedom.
    assert row["most"] - row["difference"] == pytest.approx(0.1 * stats.t.ppf(0.5 + 0.5 * level, 1), rel=1e-3)
    assert table.loc["prior", ["low", "high"]].tolist() == table.loc["prior", ["least", "most"]].tolist()


@pytest.mark.parametrize(("lost", "verdict"), [(0.5, "holds"), (1.0, OPEN), (1.5, "fails")])
def test_a_claim_that_something_does_not_matter_has_a_margin(lost, verdict):
    frame = outcomes({"wide": 0.03, "narrow": 0.05})
    own = frame["method"] == "algorithm1"
    frame.loc[own, "validation"] -= EQUIVALENT * (lost + 0.2 * np.where(frame.loc[own, "arm"] % 2, 1.0, -1.0))
    row = analysis.claims(frame).set_index("claim").loc["identical"]
    assert row["verdict"] == verdict and row["high"] < 0.0


def test_uniform_ranks_stay_in_the_band_and_narrow_claims_leave_it():
    right = outcomes({"wide": 0.0, "narrow": 0.0}, arms=40)
    table = analysis.calibration(right)
    assert set(table["method"]) == {"posterior"}
    assert ((table["share"] - table["level"]).abs() <= table["band"]).all()
    narrow = right.copy()
    narrow[list(RANKS)] = (narrow[list(RANKS)] > 0.5).astype(float)
    each = analysis.calibration(narrow).query("of == 'each'")
    assert ((each["share"] - each["level"]).abs() > each["band"]).any()


@pytest.mark.parametrize("n", [10, 60])
def test_the_band_holds_95_percent_of_uniform_samples(n):
    grid, rng = np.linspace(0.0, 1.0, 41), np.random.default_rng(11)
    half = analysis.band(n, grid)
    samples = rng.uniform(size=(3000, n, 1))
    inside = (np.abs((samples <= grid).mean(axis=1) - grid).max(axis=1) <= half).mean()
    assert inside == pytest.approx(0.95, abs=0.025)


def test_two_rows_for_one_arm_are_refused():
    one = outcomes({"wide": 0.0, "narrow": 0.0}, arms=2)
    with pytest.raises(ValueError, match="two rows"):
        analysis.maps(pd.concat([one, one.iloc[:1]]))
