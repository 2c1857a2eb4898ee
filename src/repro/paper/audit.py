"""Audit of the paper: its printed numbers and formulas against each other, each check with its arithmetic.

Only the paper is asked, not our results. A check either computes a printed number from others, or holds a
statement against the numbers it is about; where a part of the paper is lost, the note says what the check rests on.
"""

import pandas as pd

from repro.paper.checks import (
    arms,
    hardware,
    printed,
    proof,
    signals,
    similarities,
    stability_numbers,
    torque,
    training,
)
from repro.paper.checks.finding import Finding, findings_frame
from repro.paper.published import Published, load_published


def findings(published: Published | None = None) -> tuple[Finding, ...]:
    """Every finding, by subject."""
    p = load_published() if published is None else published
    return (
        *printed.totals_against_factors(p),
        *similarities.numeric_claims(p),
        *similarities.experimental_claims(p),
        *similarities.comparison_with_least_squares(p),
        *similarities.coulomb_friction(p),
        *similarities.lost_table(p),
        *arms.definiteness(p),
        *arms.training_ranges(p),
        *printed.repeated_numbers(p),
        *signals.sampling(p),
        *signals.image_and_trajectory(p),
        *signals.random_trajectories(p),
        *signals.level_factor(p),
        *training.training(p),
        *hardware.encoder(p),
        *torque.torque(p),
        *hardware.link_and_device(p),
        *stability_numbers.numbers_against_each_other(p),
        *proof.bounds(p),
        *proof.matrices(p),
        *printed.misprints(),
    )


def audit(published: Published | None = None) -> pd.DataFrame:
    """Table of every finding."""
    return findings_frame(findings(published))
