"""Every table and figure as its module declares it: those of the paper in its order, then ours."""

from importlib.metadata import entry_points

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
    time_factors,
)
from repro.exhibits.declare import Exhibit, Kind

MODULES = (  # ours in this order
    schematics, network_training, numeric_tests, causes, many_arms, arm_experiment, time_factors, print_compatible,
    paper_audit
)  # fmt: skip
#: Packages that add exhibits name one whose `MODULES` declare them, as an entry point of this group.
GROUP = "repro.exhibits"
_FURTHER = [module for entry in sorted(entry_points(group=GROUP)) for module in entry.load().MODULES]
_DECLARED = [value for module in (*MODULES, *_FURTHER) for value in vars(module).values() if isinstance(value, Exhibit)]
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
    folders = ("model/", "factorial/", "coverage/", "accepted/", "study/")
    tables = frozenset(f"{each.kind}s/{each.name}" for each in EXHIBITS if each.trained == "all")
    targets = frozenset(("training", *(each.target for each in EXHIBITS if each.trained == "claims")))
    return Tolerances(folders, tables, targets, measured_spread())


#: Targets that have a section of their own in the report.
TARGETS = frozenset(("claims", *(exhibit.target for exhibit in EXHIBITS)))
