"""Audit of the paper: its printed numbers and formulas against each other, each check with its arithmetic.

The audit uses the paper only, not our results. A check either computes a printed number from others, or compares a
statement with the numbers it is about; where a part of the paper is lost, the note names what the check assumes.
"""

import pandas as pd

from repro.paper.checks import arms, hardware, method, proof, tables
from repro.paper.checks.finding import Finding, findings_frame
from repro.paper.published import Published, load_published


def findings(published: Published | None = None) -> tuple[Finding, ...]:
    """Run every check, by subject."""
    p = load_published() if published is None else published
    return (
        *tables.totals_against_factors(p),
        *tables.numeric_claims(p),
        *tables.experimental_claims(p),
        *tables.comparison_with_least_squares(p),
        *tables.coulomb_friction(p),
        *tables.lost_table(p),
        *arms.definiteness(p),
        *arms.training_ranges(p),
        *tables.repeated_numbers(p),
        *hardware.sampling(p),
        *method.image_and_trajectory(p),
        *method.random_trajectories(p),
        *method.level_factor(),
        *method.training(p),
        *hardware.encoder(p),
        *hardware.torque(p),
        *hardware.link_and_device(p),
        *proof.numbers_against_each_other(p),
        *proof.bounds(p),
        *proof.matrices(p),
        *tables.misprints(),
    )


def audit(published: Published | None = None) -> pd.DataFrame:
    """Tabulate every finding."""
    return findings_frame(findings(published))
