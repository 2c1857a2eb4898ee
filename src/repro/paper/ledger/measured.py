"""Our side of what the paper measured or trained: parameters, similarities, the loss, and statements about them.

The arm is simulated: its real counterpart's Table 9 and recordings are not available.
"""

import math
from collections.abc import Mapping
from typing import Any

from repro.model.parameters import NAMES
from repro.paper.claims import DIFFERS, EXTENSION, REPRODUCED, Basis, Margin, Ours, higher, lower
from repro.paper.ledger.results import Results, Sample
from repro.paper.published import NUMERIC_CASES
from repro.pipeline.paired import EQUIVALENT

ALGORITHM, LEAST_SQUARES = "algorithm1", "least-squares"
EXPERIMENT_CASES = ("ID", "T1", "T2", "T3", "T4")
VALIDATION_CASES = EXPERIMENT_CASES[1:]
QUANTITIES = ("time", "frequency", "total")
#: An interval wider than one point of per cent either way compares nothing.
SIMILARITY = Margin(100.0 * EQUIVALENT, 1.0)
#: A twentieth of a parameter does not matter; an interval wider than a quarter of it compares nothing.
PARAMETER = Margin(0.05, 0.25, relative=True)
REFINEMENT, TRACKED = f"{EXTENSION}refinement", f"{EXTENSION}tracked"
#: Extensions compared with the same totals: their method, and the note of their rows.
EXTENSIONS = {
    REFINEMENT: ("algorithm1+refinement", "refinement, an extension of ours"),
    TRACKED: ("algorithm1+tracked", "closed-loop training and desired motion in line 18, an extension of ours"),
}
#: Why totals of a method on the arm differ, where they do.
_CAUSE_ON_ARM = {
    ALGORITHM: "closed-loop motion",
    "algorithm1+tracked": "image reader",
    "algorithm1+refinement": "another arm",
    LEAST_SQUARES: "another arm",
}
_OF_TABLE = {"table06": (REFINEMENT,), "table07": (REFINEMENT,), "table10": (REFINEMENT, TRACKED)}
#: Least-squares cells that the arm (ID) and the random motion (T1) were chosen by.
_CHOSEN_BY = ("ID", "T1")


def measured(results: Results, config: Mapping[str, Any]) -> dict[str, Ours]:
    """Everything in the workflow's results that the paper has too."""
    trained = training_note(config)
    loss = Ours(
        results.loss(), "training", Basis.NUMERIC, better=lower, strict=True, asserted=REPRODUCED,
        note="held-out loss, default training schedule",
    )  # fmt: skip
    return {
        **_parameters(results),
        **_similarities(results, "table07", NUMERIC_CASES, (ALGORITHM,), trained),
        **_similarities(results, "table10", EXPERIMENT_CASES, (ALGORITHM, LEAST_SQUARES), ""),
        **_tracking(results),
        **_statements(results, trained),
        **_comparisons(results),
        "section5a/loss": loss,
    }


def training_note(config: Mapping[str, Any]) -> str:
    """Name what differs from the paper in the network's training; empty if nothing does."""
    own = {"ranges": config["data"]["prior"] != "published", "schedule": config["training"]["recipe"] != "paper"}
    named = " and ".join(what for what, differs in own.items() if differs)
    return f"training {named} of the network: ours" if named else ""


def _parameters(results: Results) -> dict[str, Ours]:
    rows = {}
    for case in NUMERIC_CASES:
        table = "table04" if case in NUMERIC_CASES[:2] else "table05"
        for name in NAMES:
            true, estimate = results.parameter(table, case, ALGORITHM, name)

            def nearer(published: float, ours: float, true: float = true) -> bool:
                return abs(ours - true) < abs(published - true)

            rows[f"{table}/{case}/{ALGORITHM}/{name}"] = Ours(
                estimate.value, table, Basis.NUMERIC, estimate.spread, estimate.seeds, PARAMETER, nearer,
                cause="another network", note=f"true value {true:g}",
            )  # fmt: skip
    return rows


def _similarities(
    results: Results, table: str, cases: tuple[str, ...], methods: tuple[str, ...], note: str
) -> dict[str, Ours]:
    rows: dict[str, Ours] = {}
    for case in cases:
        for method in methods:
            middle = f"/{method}" if table == "table10" else ""
            for joint in (1, 2):
                for quantity in QUANTITIES:
                    name = f"{table}/{case}{middle}/{quantity}/joint{joint}"
                    sample = results.similarity(table, case, method, joint, quantity)
                    rows[name] = _score(sample, table, case, method, note)
                    extended = quantity == "total" and method == ALGORITHM
                    for suffix in _OF_TABLE[table] if extended else ():
                        extension, words = EXTENSIONS[suffix]
                        total = results.similarity(table, case, extension, joint, quantity)
                        rows[name + suffix] = _score(total, table, case, extension, note, words)
    return rows


def _score(sample: Sample, table: str, case: str, method: str, *notes: str) -> Ours:
    if table != "table10":
        basis, cause = Basis.NUMERIC, "another network"
    else:
        chosen = method == LEAST_SQUARES and case in _CHOSEN_BY
        basis, cause = Basis.CONSTRUCTION if chosen else Basis.ARM, _CAUSE_ON_ARM[method]
    note = "; ".join(part for part in notes if part)
    return Ours(sample.value, table, basis, sample.spread, sample.seeds, SIMILARITY, higher, cause=cause, note=note)


def _tracking(results: Results) -> dict[str, Ours]:
    # The arm's Coulomb friction and back-EMF are solved for joint 2.
    basis = {1: Basis.ARM, 2: Basis.CONSTRUCTION}
    rows = {}
    for joint in (1, 2):
        value = results.similarity("table08", "tracking", "pd", joint, "total").value
        rows[f"table08/ID/total/joint{joint}"] = Ours(
            value, "table08", basis[joint], margin=SIMILARITY, better=higher, cause="lag of the gains"
        )
    return rows


def _statements(results: Results, trained: str) -> dict[str, Ours]:
    """What abstract, discussion and conclusion state of several cases: a mean, the smallest total, or the largest."""
    rows: dict[str, Ours] = {}
    for place in ("abstract", "section6"):
        for suffix, method, words in (("", ALGORITHM, ""), (REFINEMENT, *EXTENSIONS[REFINEMENT])):
            mean = results.mean_total("table06", method, NUMERIC_CASES)
            rows[f"{place}/numeric/total{suffix}"] = _score(mean, "table06", "", method, "mean of 8", trained, words)
    for name, cases, pick, note in (
        ("abstract/experimental/total", ("ID",), min, "smaller joint of ID"),
        ("section6/experimental/total", VALIDATION_CASES, max, "largest of T1 to T4"),
        ("section7/experimental/total", VALIDATION_CASES, max, "largest of T1 to T4"),
    ):
        extended = [(suffix, *EXTENSIONS[suffix]) for suffix in _OF_TABLE["table10"]]
        for suffix, method, words in (("", ALGORITHM, ""), *extended):
            totals = [results.similarity("table10", case, method, j, "total") for case in cases for j in (1, 2)]
            chosen = pick(totals, key=lambda total: total.value)
            rows[name + suffix] = _score(chosen, "table10", cases[0], method, note, words)
    return rows


def _comparisons(results: Results) -> dict[str, Ours]:
    """What Section V-C states in words of Tables 9 and 10, as ratios."""

    def estimates(method: str) -> dict[str, float]:
        return {name: results.parameter("table09", "ID", method, name)[1].value for name in NAMES}

    def compared(
        ratio: float, table: str, asserted: str = "", note: str = "", cause: str = "closed-loop motion"
    ) -> Ours:
        return Ours(ratio, table, Basis.ARM, strict=True, asserted=asserted, cause=cause, note=note)

    ours, least_squares = estimates(ALGORITHM), estimates(LEAST_SQUARES)
    rows = {
        f"section5c/gravity-over-inertia/{method}": compared(
            _ratio(beta["g1"], max(beta[k] for k in ("I1", "I2", "I3"))), "table09"
        )
        for method, beta in ((ALGORITHM, ours), (LEAST_SQUARES, least_squares))
    }
    friction = [_ratio(ours[f"b{joint}"], ours[f"k{joint}"]) for joint in (1, 2)]
    viscous = [_ratio(least_squares[name], ours[name]) for name in ("b1", "b2")]
    rows[f"section5c/viscous-over-coulomb/{ALGORITHM}"] = compared(max(friction), "table09")
    rows["section5c/viscous-over-algorithm1"] = compared(min(viscous), "table09")
    on_id = [results.similarity("table10", "ID", method, 1, "total").value for method in (LEAST_SQUARES, ALGORITHM)]
    rows["section5c/identification/least-squares-over-algorithm1"] = compared(_ratio(*on_id), "table10")
    opponent = results.mean_total("table10", LEAST_SQUARES, VALIDATION_CASES).value
    for suffix, method, words in (("", ALGORITHM, ""), *((suffix, *EXTENSIONS[suffix]) for suffix in EXTENSIONS)):
        mean = results.mean_total("table10", method, VALIDATION_CASES).value
        # The paper's central claim. Algorithm 1 as listed does not reach least squares here, whatever the network.
        asserted = "" if suffix else DIFFERS
        rows[f"section5c/validation/algorithm1-over-least-squares{suffix}"] = compared(
            _ratio(mean, opponent), "table10", asserted, words, _CAUSE_ON_ARM[method]
        )
    return rows


def _ratio(a: float, b: float) -> float:
    """Quotient of two parameters. Where b is not positive, it only shows which of both is larger: infinity or 0."""
    return a / b if b > 0.0 else math.inf if a > b else 0.0
