"""The design of the study: its cells, and the jobs that run them.

A cell is a combination of four factors. Its blocks are arms, the same in all cells of one prior, so that cells and
methods are compared on the same arms.
"""

from dataclasses import dataclass
from itertools import product

from repro.model.parameters import NAMES
from repro.pipeline.job import Config

#: Networks: of the amortised posterior, normal or a flow, and of Algorithm 1 trained on the ideal motion and on motions
#: as arms track it.
POSTERIOR, FLOW, ALGORITHM1, TRACKED = ("posterior", "flow", "algorithm1", "algorithm1+tracked")
#: Law of the training arms for each prior; tested arms are of that law, but of another one if it is mismatched.
TRAINED_ON = {"wide": "wide", "narrow": "narrow", "mismatched": "wide"}

#: Factors, and what identifies a row of the outcomes.
FACTORS = ("excitation", "discrepancy", "prior", "friction")
KEYS = (*FACTORS, "arm", "method")
#: Probability that a claimed distribution gives to values below the truth, for each parameter.
RANKS = tuple(f"u_{name}" for name in NAMES)


@dataclass(frozen=True)
class Cell:
    """One combination of the factors."""

    excitation: str
    discrepancy: float  # similarity that ordinary least squares is to reach on the excitation
    prior: str
    friction: float  # factor on the friction of the arms that are tested
    searched: bool  # whether Algorithm 1 is run, too


def cells(config: Config) -> list[Cell]:
    """All cells in order; Algorithm 1 is run in every `cnn_fraction`-th of them, balanced over pairs of factors."""
    s = config["study"]
    factors = [list(enumerate(s[name])) for name in ("excitations", "discrepancies", "priors", "frictions")]
    return [
        Cell(excitation, discrepancy, prior, friction, searched=(i + j + k + m) % s["cnn_fraction"] == 0)
        for (i, excitation), (j, discrepancy), (k, prior), (m, friction) in product(*factors)
    ]


def jobs(config: Config) -> dict[str, list[Cell]]:
    """Cells by the name of their job: those of one excitation and one prior need the same networks."""
    found: dict[str, list[Cell]] = {}
    groups: dict[str, list[Cell]] = {}
    for cell in cells(config):
        groups.setdefault(f"{cell.excitation}-{cell.prior}", []).append(cell)
    size = config["study"]["cells_per_job"]
    for name, members in groups.items():
        found |= {f"{name}-{k // size}": members[k : k + size] for k in range(0, len(members), size)}
    return found


def networks(config: Config, job: str) -> list[str]:
    """Networks that a job needs: those of Algorithm 1 only with a cell that it is run in."""
    searched = any(cell.searched for cell in jobs(config)[job])
    return [name for name in config["study"]["networks"] if searched or name not in (ALGORITHM1, TRACKED)]
