"""The design of the study: cells, each a combination of four factors on the same arms for one prior, and their jobs."""

from dataclasses import dataclass
from itertools import product

from repro.config.model import Configuration
from repro.model.parameters import NAMES

#: Networks: of the amortised posterior, normal or a flow, and of Algorithm 1 trained on the ideal motion and on motions
#: as arms track it.
NETWORKS = POSTERIOR, FLOW, ALGORITHM1, TRACKED = ("posterior", "flow", "algorithm1", "algorithm1+tracked")
#: Law of the training arms for each prior. Tested arms are of it, or of another one if it is mismatched.
TRAINED_ON = {"wide": "wide", "narrow": "narrow", "mismatched": "wide"}

#: Factors, and what identifies a row of the outcomes.
FACTORS = ("excitation", "discrepancy", "prior", "friction")
KEYS = (*FACTORS, "arm", "method")
#: Probability that a claimed distribution gives to values below the truth, for each parameter.
RANKS = tuple(f"u_{name}" for name in NAMES)


@dataclass(frozen=True)
class StudyCell:
    """One combination of the factors."""

    excitation: str
    discrepancy: float  # similarity that ordinary least squares is to reach on Eq. 10
    prior: str
    friction: float  # factor on the friction of the arms that are tested
    searched: bool  # whether Algorithm 1 is run, too


def cells(config: Configuration) -> list[StudyCell]:
    """All cells in order; Algorithm 1 is run in one of `cnn_fraction` of them.

    By default these are a Youden square for each prior: motion and discrepancy meet every friction once, each other in
    balanced incomplete blocks. So levels have different conditions, and `analysis` compares them in an additive model.
    """
    s = config.study
    factors = [enumerate(getattr(s, name)) for name in ("excitations", "discrepancies", "priors", "frictions")]
    numbered = [zip(*each, strict=True) for each in product(*factors)]
    return [
        StudyCell(**dict(zip(FACTORS, levels, strict=True)), searched=sum(numbers) % s.cnn_fraction == 0)
        for numbers, levels in numbered
    ]


def jobs(config: Configuration) -> dict[str, list[StudyCell]]:
    """Cells by the name of their job: those of one excitation and one prior need the same networks."""
    groups: dict[str, list[StudyCell]] = {}
    for cell in cells(config):
        groups.setdefault(f"{cell.excitation}-{cell.prior}", []).append(cell)
    size = config.study.cells_per_job
    starts = [(name, k) for name, members in groups.items() for k in range(0, len(members), size)]
    return {f"{name}-{k // size}": groups[name][k : k + size] for name, k in starts}


def trained(config: Configuration) -> list[tuple[str, str]]:
    """Excitation and law of the training arms, for each pair that networks learn from."""
    s = config.study
    return list(product(s.excitations, dict.fromkeys(TRAINED_ON[prior] for prior in s.priors)))


def networks(config: Configuration, job: str) -> list[str]:
    """Networks that a job needs: those of Algorithm 1 only with a cell that it is run in."""
    searched = any(cell.searched for cell in jobs(config)[job])
    return [name for name in config.study.networks if searched or name not in (ALGORITHM1, TRACKED)]
