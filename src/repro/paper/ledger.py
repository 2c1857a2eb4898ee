"""The claims ledger from its sources: our value of each published number, what is asserted, what the audit found."""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import pandas as pd

from repro.paper.audit import findings
from repro.paper.claims import LEFT_OUT, REPRODUCED, SETTING, OurValue, judge_all
from repro.paper.finding import CONTRADICTS, NOT_POSSIBLE, Finding
from repro.paper.our_values import declared_value
from repro.paper.published import Published
from repro.paper.results import REFINED, Results, measured_values

#: Kinds of number that are asserted wherever we have a value.
ASSERTED_KINDS = (SETTING, "exact", "deterministic")
#: Asserted of the numeric tests: the listed algorithm and our refinement of it reach the abstract's mean. The central
#: claim about the arm is asserted where it is computed, in the sense that it is not reproduced.
ASSERTED = ("abstract/numeric/total", f"abstract/numeric/total{REFINED.suffix}")
#: Numbers that findings of another name refute.
_REFUTED = {"appendix/sine": "appendix/domain"}


def our_values(published: Published, config: Mapping[str, Any], results: Results) -> dict[str, OurValue]:
    """Compute our value of every published number that is the paper's own."""
    audit = findings(published)
    found = {finding.id: finding.found for finding in audit}
    refuted = {refuted_number(finding): finding for finding in audit if refuted_number(finding)}
    impossible = {id_: _sentence(f) for f in audit if f.verdict == NOT_POSSIBLE for id_ in f.numbers}
    ours: dict[str, OurValue] = {}
    for number in published:
        if number.kind == LEFT_OUT:
            continue
        if number.ours.startswith("result:"):
            values = measured_values(number, results, config)
        else:
            values = {"": declared_value(number, published, config, found)}
        value = values[""]
        finding = refuted.get(number.id)
        if finding is not None:
            value = replace(value, contradicts=_sentence(finding), contradiction=_size(finding))
        elif number.id in impossible:
            value = replace(value, note=f"{value.note}; not possible: {impossible[number.id]}")
        if number.kind in ASSERTED_KINDS and value.value is not None and finding is None and not value.unused:
            value = replace(value, asserted=REPRODUCED)
        ours |= {number.id + suffix: side for suffix, side in {**values, "": value}.items()}
    for name in ASSERTED:
        ours[name] = replace(ours[name], asserted=REPRODUCED)
    return ours


def refuted_number(finding: Finding) -> str:
    """Id of the one published number that a finding proves wrong; empty if it proves none wrong.

    A contradiction that does not single out one number marks none of them. Of a Total and its two factors, the Total
    is taken for the wrong one.
    """
    if finding.id in _REFUTED:
        return _REFUTED[finding.id]
    name = finding.id.removeprefix("composition/")
    return name if finding.verdict == CONTRADICTS and name in finding.numbers else ""


def _sentence(finding: Finding) -> str:
    return f"{finding.arithmetic}. {finding.note}".removesuffix(". ").rstrip(".")


def _size(finding: Finding) -> float:
    """By how much the paper contradicts itself; infinite where words do."""
    size = abs(finding.found - finding.printed)
    return size if math.isfinite(size) else math.inf


def compute(published: Published, config: Mapping[str, Any], results: Results) -> pd.DataFrame:
    """Compute the ledger from its sources."""
    return judge_all(published, our_values(published, config, results))
