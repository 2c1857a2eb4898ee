"""Our value for each published number, from the columns ``ours`` and ``note`` of ``published.csv``.

======================= ================================================================================
``config:EXPR``          keys of the configuration
``schedule:EXPR``        keys of the paper's training schedule, which the default network does not use
``const:MODULE:EXPR``    names of a module of this package
``arithmetic:EXPR``      keys of the configuration, names of `MODULES`, other printed numbers and the audit
``result:SOURCE``        result files: an entry of `RESULT_SOURCES`
``bench``                nothing: a property of the authors' arm, board or bench
======================= ================================================================================

Expressions are those of `repro.paper.published.evaluate`. In a note, ``{EXPR}`` is replaced by its value.
"""

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import ModuleType

import numpy as np
import pandas as pd

from repro.board import frames
from repro.cnn import architecture, image, priors
from repro.cnn.architecture import HISTORY_COLUMNS
from repro.comparison import LEDGER
from repro.config.model import Configuration
from repro.config.sections import plain
from repro.errors import InputError
from repro.experiments.monte_carlo import EQUIVALENT
from repro.files import read_rows
from repro.model import dynamics, parameters, stability
from repro.model.parameters import NAMES
from repro.paper.claims import DIFFERS, EXTENSION, SETTING, Basis, OurValue, higher, lower
from repro.paper.published import NUMERIC_CASES, Published, PublishedValue, evaluate
from repro.signals import programs, trajectories, validation_motions

#: Modules by their names in the column.
MODULES: dict[str, ModuleType] = {
    module.__name__.removeprefix("repro."): module
    for module in (
        architecture, image, priors, frames, dynamics, parameters, stability, programs, trajectories, validation_motions
    )
}  # fmt: skip


def _first_key(expression: str) -> str:
    """Return the first key of the configuration in an expression, without indices of list items."""
    dotted = re.sub(r"\['([\w-]+)'\]", r".\1", expression)
    keys: list[str] = re.findall(r"[a-z][\w-]*(?:\.[\w-]+)+", dotted)
    return next(key for key in keys if key.partition(".")[0] in Configuration.model_fields)


SCORES = ("case", "method", "seed", "joint", "time", "frequency", "total")
SIMILARITY = ("case", "method", "joint", "time", "frequency", "total")
PARAMETERS = ("case", "method", "parameter", "true", "estimate", "estimate_sd")

#: Result files by their path in the results folder, and the columns that each must have.
FILES: dict[str, tuple[str, ...]] = {
    **{f"tables/table{number}.csv": PARAMETERS for number in ("04", "05", "09")},
    **{f"tables/table{number}.csv": SIMILARITY for number in ("06", "07", "08", "10")},
    "tables/stability.csv": ("method", "quantity", "value", "bound"),
    "tables/board_size.csv": ("block", "quantity", "least", "most"),
    "model/training.csv": HISTORY_COLUMNS,
    "validation/numeric.csv": (*SCORES, "trajectory"),
    "validation/experiment.csv": SCORES,
}

#: Scores of every seed behind a table of medians: their file, and the trajectory that the table is about.
_SEEDS = {
    **dict.fromkeys(("table04", "table05", "table06"), ("validation/numeric.csv", {"trajectory": "ID"})),
    "table07": ("validation/numeric.csv", {"trajectory": "validation"}),
    "table10": ("validation/experiment.csv", {}),
}


class Results:
    """Numbers of a results folder by what they are."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        # As text, so that a message shows what the file has.
        self.frames = {
            name: pd.DataFrame(read_rows(folder / name, names), columns=names) for name, names in FILES.items()
        }

    def rows(self, name: str, **wanted: object) -> pd.DataFrame:
        """Rows of a file that have these values: one at least."""
        frame = self.frames[name]
        for column, value in wanted.items():
            frame = frame[frame[column] == str(value)]
        if frame.empty:
            raise InputError.at(str(self._folder / name), f"no row of {_words(wanted)}", "one")
        return frame

    def number(self, name: str, column: str, **wanted: object) -> float:
        """Cell of the first row that has these values, a finite number."""
        text = self.rows(name, **wanted)[column].iloc[0]
        number = pd.to_numeric(text, errors="coerce")
        if not np.isfinite(number):
            place = f"{self._folder / name}: {column} of {_words(wanted)}"
            raise InputError.at(place, text or "nothing", "a finite number")
        return float(number)

    def totals(self, table: str, quantity: str = "total", **wanted: object) -> pd.Series:
        """Similarities of every seed behind rows of a table, %, by the seed; none for a table of one run."""
        if table not in _SEEDS:
            return pd.Series(dtype=float)
        name, trajectory = _SEEDS[table]
        rows = self.rows(name, **wanted, **trajectory)
        return 100.0 * pd.to_numeric(rows[quantity], errors="coerce").set_axis(rows["seed"])

    def similarity(self, table: str, case: str, method: str, joint: int, quantity: str = "total") -> OurValue:
        """Similarity of a table, %."""
        row = {"case": case, "method": method, "joint": joint}
        value = 100.0 * self.number(f"tables/{table}.csv", quantity, **row)
        return _similarity_of(value, table, self.totals(table, quantity, **row))

    def mean_total(self, table: str, method: str, cases: tuple[str, ...]) -> OurValue:
        """Mean of the totals of both joints in some cases, %."""
        cells = [self.similarity(table, case, method, joint).value for case in cases for joint in (1, 2)]
        scores = pd.concat([self.totals(table, case=case, method=method) for case in cases])
        return _similarity_of(float(np.mean(cells)), table, scores.groupby(level=0).mean())


def _similarity_of(value: float, table: str, scores: pd.Series) -> OurValue:
    # An interval wider than one point of per cent either way compares nothing.
    ours = OurValue(value, table, equivalent=100.0 * EQUIVALENT, cap=1.0, better=higher)
    return replace(ours, std=float(scores.std()), seeds=len(scores)) if len(scores) > 1 else ours


def _words(wanted: Mapping[str, object]) -> str:
    return ", ".join(f"{column} {value}" for column, value in wanted.items())


ALGORITHM, LEAST_SQUARES = "algorithm1", "least-squares"
VALIDATION_CASES = ("T1", "T2", "T3", "T4")


@dataclass(frozen=True)
class Variant:
    """A method of ours that is compared with a published number of Algorithm 1."""

    suffix: str  # of the id in the ledger
    method: str
    note: str
    cause: str  # why it differs on the simulated arm, where it does


LISTED = Variant("", ALGORITHM, "", "closed-loop motion")
REFINED = Variant(f"{EXTENSION}refinement", "algorithm1+refinement", "refinement, an extension of ours", "another arm")
CLOSED_LOOP = Variant(
    f"{EXTENSION}tracked", "algorithm1+tracked",
    "closed-loop training and desired motion in line 18, an extension of ours", "image reader",
)  # fmt: skip
LINEAR = Variant("", LEAST_SQUARES, "", "another arm")
VARIANTS = {"table06": (LISTED, REFINED), "table07": (LISTED, REFINED), "table10": (LISTED, REFINED, CLOSED_LOOP)}
#: Our values by the suffix of their id: empty, or that of an extension.
Values = dict[str, OurValue]


def training_note(config: Configuration) -> str:
    """Name what differs from the paper in the network's training; empty if nothing does."""
    own = {"ranges": config.data.prior != "published", "schedule": config.training.recipe != "paper"}
    differing = " and ".join(what for what, differs in own.items() if differs)
    return f"training {differing} of the network: ours" if differing else ""


def _score(score: OurValue, variant: Variant, *notes: str) -> OurValue:
    basis, cause = Basis.NUMERIC, "another network"
    if score.target == "table10":  # arm and motions are matched to the cells of least squares
        basis, cause = Basis.CONSTRUCTION if variant.method == LEAST_SQUARES else Basis.ARM, variant.cause
    return replace(score, basis=basis, cause=cause, note="; ".join(filter(None, (*notes, variant.note))))


def _similarity(number: PublishedValue, results: Results, config: Configuration) -> Values:
    """Cell of Table 7 or 10."""
    table, case, joint = number.id.partition("/")[0], number.case, number.joint or 0
    note = training_note(config) if table == "table07" else ""
    variants = (LINEAR,) if number.method == LEAST_SQUARES else VARIANTS[table]
    values = {}
    for variant in variants if number.quantity == "total" else variants[:1]:
        score = results.similarity(table, case, variant.method, joint, number.quantity)
        values[variant.suffix] = _score(score, variant, note)
    return values


def _parameter(number: PublishedValue, results: Results, _: Configuration) -> Values:
    """Cell of Table 4 or 5."""
    table, run = number.id.partition("/")[0], {"case": number.case, "method": ALGORITHM}
    file, row = f"tables/{table}.csv", {**run, "parameter": number.parameter}
    true, estimate, sd = (results.number(file, column, **row) for column in ("true", "estimate", "estimate_sd"))
    seeds = results.totals(table, **run).index.nunique()

    def nearer(published: float, ours: float) -> bool:
        return abs(ours - true) < abs(published - true)

    ours = OurValue(estimate, table, Basis.NUMERIC, sd, seeds, cause="another network", note=f"true value {true:g}")
    # A twentieth of a parameter does not matter; an interval wider than a quarter of it compares nothing.
    equivalent, cap = 0.05 * abs(number.value), 0.25 * abs(number.value)
    return {"": replace(ours, equivalent=equivalent, cap=cap, better=nearer)}


def _tracking(number: PublishedValue, results: Results, _: Configuration) -> Values:
    """Cell of Table 8, to which arm and duration of ID are matched."""
    value = results.similarity("table08", "tracking", "pd", number.joint or 0)
    return {"": replace(value, basis=Basis.CONSTRUCTION, cause="lag of the gains")}


def _mean(number: PublishedValue, results: Results, config: Configuration) -> Values:
    """Mean of the eight totals of Table 6."""
    means = {variant: results.mean_total("table06", variant.method, NUMERIC_CASES) for variant in VARIANTS["table06"]}
    values = {}
    for variant, mean in means.items():
        totals = [
            results.similarity("table06", case, variant.method, j).value for case in NUMERIC_CASES for j in (1, 2)
        ]
        notes = number.note, f"smallest {min(totals):.2f}", training_note(config)
        values[variant.suffix] = _score(mean, variant, *notes)
    return values


def _extreme(number: PublishedValue, results: Results, _: Configuration) -> Values:
    """Smallest total of ID, or largest total of the validation motions, in Table 10."""
    cases, choose = (("ID",), min) if number.ours.endswith("smallest") else (VALIDATION_CASES, max)
    values = {}
    for variant in VARIANTS["table10"]:
        totals = [results.similarity("table10", case, variant.method, j) for case in cases for j in (1, 2)]
        extreme = choose(totals, key=lambda total: total.value)
        values[variant.suffix] = _score(extreme, variant, number.note)
    return values


def _stability(number: PublishedValue, results: Results, _: Configuration) -> Values:
    """Number of Appendix A for the arm behind the simulated board."""
    file, (quantity, column) = "tables/stability.csv", number.ours.rpartition(":")[2].split(".")
    names = results.rows(file, method="appendix")["quantity"]
    full = next((text for text in names if text.startswith(quantity)), quantity)
    value = results.number(file, column, method="appendix", quantity=full)
    return {"": OurValue(value, "stability", note=number.note)}


def _board(number: PublishedValue, results: Results, _: Configuration) -> Values:
    """Number of the board in logic: exact, or the middle of the bounds of its synthesis."""
    block, quantity = number.ours.rpartition(":")[2].split(".")
    row = {"block": block, "quantity": quantity}
    least, most = (results.number("tables/board_size.csv", bound, **row) for bound in ("least", "most"))
    note = f"{least:g} to {most:g}; {number.note}" if least < most else number.note
    middle, strict = 0.5 * (least + most), number.kind == SETTING
    cause = "" if strict else "another board"
    return {"": OurValue(middle, "board_size", bounds=most - middle, strict=strict, cause=cause, note=note)}


def _loss(number: PublishedValue, results: Results, config: Configuration) -> Values:
    """Held-out loss at the end of the training."""
    file, note = "model/training.csv", number.note
    loss = results.number(file, "test_loss", step=results.frames[file]["step"].iloc[-1])
    unused = config.training.recipe != "paper"  # the loss of other samples and another schedule
    return {"": OurValue(loss, "training", Basis.NUMERIC, better=lower, strict=True, unused=unused, note=note)}


def _parameter_ratio(number: PublishedValue, results: Results, _: Configuration) -> Values:
    """Ratio of parameters of Table 9, which Section V-C states in words."""

    def estimates(method: str) -> dict[str, float]:
        row = {"case": "ID", "method": method}
        return {name: results.number("tables/table09.csv", "estimate", **row, parameter=name) for name in NAMES}

    statement = number.ours.rpartition(":")[2]
    beta = estimates(number.method or ALGORITHM)
    if statement == "gravity-over-inertia":
        ratio = _ratio(beta["g1"], max(beta[name] for name in ("I1", "I2", "I3")))
    elif statement == "viscous-over-coulomb":
        ratio = max(_ratio(beta[f"b{joint}"], beta[f"k{joint}"]) for joint in (1, 2))
    else:
        least_squares = estimates(LEAST_SQUARES)
        ratio = min(_ratio(least_squares[name], beta[name]) for name in ("b1", "b2"))
    # The arm was chosen with g1 above the inertias and friction more Coulomb than viscous.
    basis = Basis.ARM if statement == "viscous-over-viscous" else Basis.CONSTRUCTION
    return {"": OurValue(ratio, "table09", basis, strict=True, cause=LISTED.cause)}


def _total_ratio(number: PublishedValue, results: Results, _: Configuration) -> Values:
    """Total of least squares over that of Algorithm 1 for joint 1 of ID."""
    least_squares, ours = (results.similarity("table10", "ID", name, 1).value for name in (LEAST_SQUARES, ALGORITHM))
    ratio = _ratio(least_squares, ours)
    return {"": OurValue(ratio, "table10", Basis.ARM, strict=True, cause=LISTED.cause, note=number.note)}


def _validation_ratio(_: PublishedValue, results: Results, __: Configuration) -> Values:
    """Mean total of Algorithm 1 over that of least squares: the paper's central claim."""
    baseline = results.mean_total("table10", LEAST_SQUARES, VALIDATION_CASES).value
    values = {}
    for variant in VARIANTS["table10"]:
        ratio = _ratio(results.mean_total("table10", variant.method, VALIDATION_CASES).value, baseline)
        values[variant.suffix] = OurValue(
            ratio, "table10", Basis.ARM, strict=True, cause=variant.cause, note=variant.note,
            asserted="" if variant.suffix else DIFFERS,  # as listed it is below least squares, whatever the network
        )  # fmt: skip
    return values


def _ratio(a: float, b: float) -> float:
    """Quotient of two parameters. Where b is not positive, it only shows which of both is larger: infinity or 0."""
    return a / b if b > 0.0 else math.inf if a > b else 0.0


#: Sources of numbers in the result files, by their names in the column.
RESULT_SOURCES: dict[str, Callable[[PublishedValue, Results, Configuration], Values]] = {
    "board": _board,
    "largest": _extreme,
    "loss": _loss,
    "mean": _mean,
    "parameter": _parameter,
    "parameter-ratio": _parameter_ratio,
    "similarity": _similarity,
    "smallest": _extreme,
    "stability": _stability,
    "total-ratio": _total_ratio,
    "tracking": _tracking,
    "validation-ratio": _validation_ratio,
}


def values_of(
    number: PublishedValue,
    published: Published,
    config: Configuration,
    audit: Mapping[str, float],
    results: Results,
) -> Values:
    """Compute our values of a number; `audit` has the values found, by finding."""
    source, _, expression = number.ours.partition(":")
    if source == "bench":
        return {"": OurValue(math.nan, "", note=number.note)}
    if source == "result":
        return RESULT_SOURCES[expression.partition(":")[0]](number, results, config)
    module, names = "", {"pi": math.pi, "CIRCLE_RADIUS": validation_motions.CIRCLE_RADIUS, **plain(config)}
    if source == "const":
        module, _, expression = expression.partition(":")
        names = vars(MODULES[module]) if module in MODULES else {}
    elif source == "arithmetic":
        names |= {"frames": frames, "audit": audit, "printed": {each.id: each.value for each in published}}
    try:
        value = float(evaluate(expression, names))
    except (ValueError, TypeError, LookupError, AttributeError, SyntaxError) as error:
        raise ValueError(f"{number.id}: ours: {number.ours} is no arithmetic on known names: {error}") from error
    if source == "arithmetic":
        field = re.compile(r"\{([^:}]+)(?::([^}]+))?\}")
        note = field.sub(lambda match: format(evaluate(match[1], names), match[2] or "g"), number.note)
        return {"": OurValue(value, LEDGER, Basis.ARITHMETIC, note=note)}
    if source == "const":
        note = "; ".join(filter(None, (number.note, "repro." + module)))
        return {"": OurValue(value, LEDGER, strict=True, note=note)}
    note = ", ".join(filter(None, (f"config/config.yaml: {_first_key(expression)}", number.note)))
    unused = source == "schedule" and config.training.recipe != "paper"
    return {"": OurValue(value, LEDGER, strict=True, unused=unused, note=note)}
