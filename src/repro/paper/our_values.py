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
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pandas as pd

from repro.cnn import architecture, image, priors
from repro.cnn.architecture import HISTORY_COLUMNS
from repro.comparison import LEDGER
from repro.errors import InputError
from repro.files import read_rows
from repro.fpga import frames
from repro.model import dynamics, parameters, stability
from repro.model.parameters import NAMES
from repro.paper.claims import DIFFERS, EXTENSION, REPRODUCED, SETTING, Basis, Margin, OurValue, higher, lower
from repro.paper.published import NUMERIC_CASES, Published, PublishedValue, evaluate
from repro.pipeline.monte_carlo import EQUIVALENT
from repro.signals import programs, trajectories, validation_motions

CONFIG_FILE = "config/config.yaml"
#: Modules by their names in the column; what two modules share is looked up where it is defined.
MODULES: dict[str, ModuleType] = {
    "cnn.architecture": architecture,
    "cnn.image": image,
    "cnn.network": architecture,
    "cnn.priors": priors,
    "fpga.frames": frames,
    "identification.algorithm1": parameters,
    "model.dynamics": dynamics,
    "model.stability": stability,
    "signals.programs": programs,
    "signals.trajectories": trajectories,
    "signals.validation_motions": validation_motions,
}


def _first_key(expression: str, config: Mapping[str, Any]) -> str:
    """Return the first key of the configuration in an expression, without indices of list items."""
    dotted = re.sub(r"\['([\w-]+)'\]", r".\1", expression)
    keys: list[str] = re.findall(r"[a-z][\w-]*(?:\.[\w-]+)+", dotted)
    return next(key for key in keys if key.partition(".")[0] in config)


SCORES = ("case", "method", "seed", "joint", "time", "frequency", "total")
SIMILARITY = ("case", "method", "joint", "time", "frequency", "total")
PARAMETERS = ("case", "method", "parameter", "true", "estimate", "estimate_sd")

#: Result files by their path in the results folder, and the columns that each must have.
FILES: dict[str, tuple[str, ...]] = {
    "tables/table04.csv": PARAMETERS,
    "tables/table05.csv": PARAMETERS,
    "tables/table06.csv": SIMILARITY,
    "tables/table07.csv": SIMILARITY,
    "tables/table08.csv": SIMILARITY,
    "tables/table09.csv": PARAMETERS,
    "tables/table10.csv": SIMILARITY,
    "tables/stability.csv": ("method", "quantity", "value", "bound"),
    "tables/board_size.csv": ("block", "quantity", "least", "most"),
    "model/training.csv": HISTORY_COLUMNS,
    "validation/numeric.csv": (*SCORES, "trajectory"),
    "validation/experiment.csv": SCORES,
}

#: Scores of every seed behind a table of medians, and the trajectory that the table is about.
_SEEDS = {
    "table04": ("validation/numeric.csv", "ID"),
    "table05": ("validation/numeric.csv", "ID"),
    "table06": ("validation/numeric.csv", "ID"),
    "table07": ("validation/numeric.csv", "validation"),
    "table10": ("validation/experiment.csv", ""),
}


@dataclass(frozen=True)
class Sample:
    """A number of a table, and its scatter over the seeds."""

    value: float
    std: float = 0.0
    seeds: int = 1


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

    def _totals(self, table: str, quantity: str = "total", **wanted: object) -> pd.Series:
        """Similarities of every seed behind rows of a table, %, by the seed."""
        name, trajectory = _SEEDS[table]
        rows = self.rows(name, **wanted, **({"trajectory": trajectory} if trajectory else {}))
        return 100.0 * pd.to_numeric(rows[quantity], errors="coerce").set_axis(rows["seed"])

    def similarity(self, table: str, case: str, method: str, joint: int, quantity: str) -> Sample:
        """Similarity of a table, %."""
        row = {"case": case, "method": method, "joint": joint}
        value = 100.0 * self.number(f"tables/{table}.csv", quantity, **row)
        return _sample(value, self._totals(table, quantity, **row)) if table in _SEEDS else Sample(value)

    def mean_total(self, table: str, method: str, cases: tuple[str, ...]) -> Sample:
        """Mean of the totals of both joints in some cases, %."""
        cells = [self.similarity(table, case, method, joint, "total").value for case in cases for joint in (1, 2)]
        scores = pd.concat([self._totals(table, case=case, method=method) for case in cases])
        return _sample(float(np.mean(cells)), scores.groupby(level=0).mean())

    def parameter(self, table: str, case: str, method: str, name: str) -> tuple[float, Sample]:
        """True value of a parameter, and its estimate, SI units."""
        row = {"case": case, "method": method, "parameter": name}
        true, estimate, sd = (self.number(f"tables/{table}.csv", c, **row) for c in PARAMETERS[3:])
        seeds = self._totals(table, case=case, method=method).index.nunique() if table in _SEEDS else 1
        return true, Sample(estimate, sd, seeds)


def _sample(value: float, scores: pd.Series) -> Sample:
    return Sample(value, float(scores.std(ddof=1)), len(scores)) if len(scores) > 1 else Sample(value)


def _words(wanted: Mapping[str, object]) -> str:
    return ", ".join(f"{column} {value}" for column, value in wanted.items())


ALGORITHM, LEAST_SQUARES = "algorithm1", "least-squares"
VALIDATION_CASES = ("T1", "T2", "T3", "T4")
#: An interval wider than one point of per cent either way compares nothing.
SIMILARITY_MARGIN = Margin(100.0 * EQUIVALENT, 1.0)


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
#: Least-squares cells that the arm (ID) and the random motion (T1) were calibrated on.
CALIBRATED_ON = ("ID", "T1")

#: Our values by the suffix of their id: empty, or that of an extension.
Values = dict[str, OurValue]


def training_note(config: Mapping[str, Any]) -> str:
    """Name what differs from the paper in the network's training; empty if nothing does."""
    own = {"ranges": config["data"]["prior"] != "published", "schedule": config["training"]["recipe"] != "paper"}
    differing = " and ".join(what for what, differs in own.items() if differs)
    return f"training {differing} of the network: ours" if differing else ""


def _score(sample: Sample, table: str, case: str, variant: Variant, *notes: str) -> OurValue:
    basis, cause = Basis.NUMERIC, "another network"
    if table == "table10":
        calibrated = variant.method == LEAST_SQUARES and case in CALIBRATED_ON
        basis, cause = Basis.CONSTRUCTION if calibrated else Basis.ARM, variant.cause
    note = "; ".join(filter(None, (*notes, variant.note)))
    return OurValue(
        sample.value, table, basis, sample.std, sample.seeds, SIMILARITY_MARGIN, higher, cause=cause, note=note
    )


def _similarity(number: PublishedValue, results: Results, config: Mapping[str, Any]) -> Values:
    """Cell of Table 7 or 10."""
    table, case, joint = number.id.partition("/")[0], number.case, number.joint or 0
    note = training_note(config) if table == "table07" else ""
    variants = (LINEAR,) if number.method == LEAST_SQUARES else VARIANTS[table]
    samples = {
        variant: results.similarity(table, case, variant.method, joint, number.quantity)
        for variant in (variants if number.quantity == "total" else variants[:1])
    }
    return {variant.suffix: _score(sample, table, case, variant, note) for variant, sample in samples.items()}


def _parameter(number: PublishedValue, results: Results, _: Mapping[str, Any]) -> Values:
    """Cell of Table 4 or 5."""
    table = number.id.partition("/")[0]
    true, estimate = results.parameter(table, number.case, ALGORITHM, number.parameter)

    def nearer(published: float, ours: float) -> bool:
        return abs(ours - true) < abs(published - true)

    # A twentieth of a parameter does not matter; an interval wider than a quarter of it compares nothing.
    margin = Margin(0.05 * abs(number.value), 0.25 * abs(number.value))
    ours = OurValue(
        estimate.value, table, Basis.NUMERIC, estimate.std, estimate.seeds, margin, nearer,
        cause="another network", note=f"true value {true:g}",
    )  # fmt: skip
    return {"": ours}


def _tracking(number: PublishedValue, results: Results, _: Mapping[str, Any]) -> Values:
    """Cell of Table 8. The arm's Coulomb friction and back-EMF are solved for joint 2."""
    value = results.similarity("table08", "tracking", "pd", number.joint or 0, "total").value
    basis = Basis.CONSTRUCTION if number.joint == 2 else Basis.ARM
    return {"": OurValue(value, "table08", basis, margin=SIMILARITY_MARGIN, better=higher, cause="lag of the gains")}


def _mean(number: PublishedValue, results: Results, config: Mapping[str, Any]) -> Values:
    """Mean of the eight totals of Table 6."""
    notes = number.note, training_note(config)
    means = {variant: results.mean_total("table06", variant.method, NUMERIC_CASES) for variant in VARIANTS["table06"]}
    return {variant.suffix: _score(mean, "table06", "", variant, *notes) for variant, mean in means.items()}


def _extreme(number: PublishedValue, results: Results, _: Mapping[str, Any]) -> Values:
    """Smallest total of ID, or largest total of the validation motions, in Table 10."""
    smallest = number.ours.endswith("smallest")
    cases, choose = (("ID",), min) if smallest else (VALIDATION_CASES, max)
    values = {}
    for variant in VARIANTS["table10"]:
        totals = [results.similarity("table10", case, variant.method, j, "total") for case in cases for j in (1, 2)]
        extreme = choose(totals, key=lambda total: total.value)
        values[variant.suffix] = _score(extreme, "table10", cases[0], variant, number.note)
    return values


def _stability(number: PublishedValue, results: Results, _: Mapping[str, Any]) -> Values:
    """Number of Appendix A for the arm behind the simulated board."""
    file, (quantity, column) = "tables/stability.csv", number.ours.rpartition(":")[2].split(".")
    names = results.rows(file, method="appendix")["quantity"]
    full = next((text for text in names if text.startswith(quantity)), quantity)
    value = results.number(file, column, method="appendix", quantity=full)
    return {"": OurValue(value, "stability", note=number.note)}


def _board(number: PublishedValue, results: Results, _: Mapping[str, Any]) -> Values:
    """Number of the board in logic: exact, or the middle of the bounds of its synthesis."""
    block, quantity = number.ours.rpartition(":")[2].split(".")
    row = {"block": block, "quantity": quantity}
    least, most = (results.number("tables/board_size.csv", bound, **row) for bound in ("least", "most"))
    note = f"{least:g} to {most:g}; {number.note}" if least < most else number.note
    middle, strict = 0.5 * (least + most), number.kind == SETTING
    ours = OurValue(
        middle, "board_size", bounds=most - middle, strict=strict, cause="" if strict else "another board", note=note
    )
    return {"": ours}


def _loss(number: PublishedValue, results: Results, _: Mapping[str, Any]) -> Values:
    """Held-out loss at the end of the training."""
    file, note = "model/training.csv", number.note
    loss = results.number(file, "test_loss", step=results.frames[file]["step"].iloc[-1])
    return {"": OurValue(loss, "training", Basis.NUMERIC, better=lower, strict=True, asserted=REPRODUCED, note=note)}


def _parameter_ratio(number: PublishedValue, results: Results, _: Mapping[str, Any]) -> Values:
    """Ratio of parameters of Table 9, which Section V-C states in words."""

    def estimates(method: str) -> dict[str, float]:
        return {name: results.parameter("table09", "ID", method, name)[1].value for name in NAMES}

    statement = number.ours.rpartition(":")[2]
    beta = estimates(number.method or ALGORITHM)
    if statement == "gravity-over-inertia":
        ratio = _ratio(beta["g1"], max(beta[name] for name in ("I1", "I2", "I3")))
    elif statement == "viscous-over-coulomb":
        ratio = max(_ratio(beta[f"b{joint}"], beta[f"k{joint}"]) for joint in (1, 2))
    else:
        least_squares = estimates(LEAST_SQUARES)
        ratio = min(_ratio(least_squares[name], beta[name]) for name in ("b1", "b2"))
    return {"": _stated(ratio, "table09", LISTED.cause)}


def _total_ratio(_: PublishedValue, results: Results, __: Mapping[str, Any]) -> Values:
    """Total of least squares over that of Algorithm 1 for joint 1 of ID."""
    totals = [results.similarity("table10", "ID", method, 1, "total").value for method in (LEAST_SQUARES, ALGORITHM)]
    return {"": _stated(_ratio(*totals), "table10", LISTED.cause)}


def _validation_ratio(_: PublishedValue, results: Results, __: Mapping[str, Any]) -> Values:
    """Mean total of Algorithm 1 over that of least squares: the paper's central claim."""
    baseline = results.mean_total("table10", LEAST_SQUARES, VALIDATION_CASES).value
    values = {}
    for variant in VARIANTS["table10"]:
        ratio = _ratio(results.mean_total("table10", variant.method, VALIDATION_CASES).value, baseline)
        asserted = "" if variant.suffix else DIFFERS  # as listed it does not reach least squares, whatever the network
        values[variant.suffix] = _stated(ratio, "table10", variant.cause, asserted, variant.note)
    return values


def _stated(ratio: float, table: str, cause: str, asserted: str = "", note: str = "") -> OurValue:
    return OurValue(ratio, table, Basis.ARM, strict=True, asserted=asserted, cause=cause, note=note)


def _ratio(a: float, b: float) -> float:
    """Quotient of two parameters. Where b is not positive, it only shows which of both is larger: infinity or 0."""
    return a / b if b > 0.0 else math.inf if a > b else 0.0


#: Sources of numbers in the result files, by their names in the column.
RESULT_SOURCES: dict[str, Callable[[PublishedValue, Results, Mapping[str, Any]], Values]] = {
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
    config: Mapping[str, Any],
    audit: Mapping[str, float],
    results: Results,
) -> Values:
    """Compute our values of a number; `audit` has the values found, by finding."""
    source, _, expression = number.ours.partition(":")
    if source == "bench":
        return {"": OurValue(None, "", note=number.note)}
    if source == "result":
        return RESULT_SOURCES[expression.partition(":")[0]](number, results, config)
    module, names = "", {"pi": math.pi, "CIRCLE_RADIUS": validation_motions.CIRCLE_RADIUS, **config}
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
        note = re.sub(
            r"\{([^:}]+)(?::([^}]+))?\}", lambda match: format(evaluate(match[1], names), match[2] or "g"), number.note
        )
        return {"": OurValue(value, LEDGER, Basis.ARITHMETIC, note=note)}
    if source == "const":
        note = "; ".join(filter(None, (number.note, "repro." + module)))
        return {"": OurValue(value, LEDGER, strict=True, note=note)}
    note = ", ".join(filter(None, (f"{CONFIG_FILE}: {_first_key(expression, config)}", number.note)))
    unused = source == "schedule" and config["training"]["recipe"] != "paper"
    return {"": OurValue(value, LEDGER, strict=True, unused=unused, note=note)}
