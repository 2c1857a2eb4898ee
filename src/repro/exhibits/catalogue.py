"""Every table and figure as its module declares it: those of the paper in its order, then ours."""

from repro.comparison import Tolerances, measured_spread
from repro.exhibits import (
    arm_experiment,
    causes,
    many_arms,
    network_training,
    numeric_tests,
    paper_audit,
    print_compatible,
    schematics,
    study_results,
    variants,
)
from repro.exhibits.declare import Exhibit, Kind

MODULES = (  # ours in this order
    schematics, network_training, numeric_tests, causes, many_arms, arm_experiment, variants, study_results,
    print_compatible, paper_audit
)  # fmt: skip
_DECLARED = [value for module in MODULES for value in vars(module).values() if isinstance(value, Exhibit)]
#: Has a section of its own in the report.
(AUDIT,) = (exhibit for exhibit in _DECLARED if exhibit.category == "Claims")


def _ordered(kind: Kind) -> tuple[Exhibit, ...]:
    chosen = [exhibit for exhibit in _DECLARED if exhibit.kind == kind and exhibit is not AUDIT]
    return tuple(sorted(chosen, key=lambda each: (each.number or 99, each.optional)))


TABLES, FIGURES = _ordered("table"), _ordered("figure")
EXHIBITS = (*TABLES, *FIGURES, AUDIT)


def tolerances() -> Tolerances:
    """How two runs may differ, by what each exhibit declares and by the measured spread of the networks."""
    # All floats here depend on a network, a random search, or arms that are simulated again: the loop of a light arm is
    # chaotic, so that another last bit moves a score of any method by up to 0.1 (docs/numbers.md).
    folders = ("model/", "factorial/", "coverage/", "spread/", "accepted/")
    tables = frozenset(f"{each.kind}s/{each.name}" for each in EXHIBITS if each.trained == "all")
    targets = frozenset(("training", *(each.target for each in EXHIBITS if each.trained == "claims")))
    return Tolerances(folders, tables, targets, measured_spread())


#: Targets that have a section of their own in the report.
TARGETS = frozenset(("claims", *(exhibit.target for exhibit in EXHIBITS)))
