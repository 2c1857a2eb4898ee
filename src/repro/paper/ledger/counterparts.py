"""Our side of all published numbers: what each is compared with, what we promise, what the audit found."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import pandas as pd

from repro.paper.audit import findings
from repro.paper.checks.finding import CONTRADICTS, NOT_POSSIBLE, Finding
from repro.paper.claims import LEFT_OUT, SETTING, Ours, ledger
from repro.paper.ledger.arithmetic import arithmetic
from repro.paper.ledger.choices import choices
from repro.paper.ledger.constants import constants
from repro.paper.ledger.measured import REFINEMENT, measured
from repro.paper.ledger.results import Results
from repro.paper.published import Published

#: Kinds of number that must hold wherever we have a counterpart.
MUST_KINDS = (SETTING, "exact", "deterministic")
#: Statements about all cases, and places, that our extension must reach.
MUST_REFINED = tuple(
    f"{name}{REFINEMENT}"
    for name in (
        "abstract/numeric/total",
        "abstract/experimental/total",
        "table10/ID/algorithm1/total/joint1",
        "table10/ID/algorithm1/total/joint2",
    )
)
_HARDWARE = "property of the authors' arm, board or bench"
#: Findings that are about one published number under another name than its id.
_ABOUT = {"appendix/sine": "appendix/domain"}


def counterparts(published: Published, config: Mapping[str, Any], results: Results) -> dict[str, Ours]:
    """Our side of every published number that is the paper's own."""
    found = {**choices(config), **constants(), **arithmetic(published, config, results), **measured(results)}
    audited = findings(published)
    contradictions = {about(finding): finding for finding in audited if about(finding)}
    remarks = {number: _told(f) for f in audited if f.verdict == NOT_POSSIBLE for number in f.numbers}
    whole: dict[str, Ours] = {}
    for number in published:
        if number.kind == LEFT_OUT:
            continue
        side = found.pop(number.id, Ours(None, "", note=_HARDWARE))
        finding = contradictions.get(number.id)
        if finding is not None:
            side = replace(side, contradicts=_told(finding))
        elif number.id in remarks:
            side = replace(side, note=f"{side.note}; not possible: {remarks[number.id]}")
        promised = number.kind in MUST_KINDS and side.value is not None and finding is None and not side.unused
        whole[number.id] = replace(side, must=side.must or promised)
    for name in MUST_REFINED:
        found[name] = replace(found[name], must=True, strict=True)
    return {**whole, **found}


def about(finding: Finding) -> str:
    """Id of the one published number that a finding proves wrong; empty if it proves none wrong.

    A contradiction between several numbers, of which it does not say which is wrong, paints over none of them; a
    Total that is not the product of its factors is taken for the wrong one of the three.
    """
    if finding.id in _ABOUT:
        return _ABOUT[finding.id]
    name = finding.id.removeprefix("composition/")
    return name if finding.verdict == CONTRADICTS and name in finding.numbers else ""


def _told(finding: Finding) -> str:
    return f"{finding.arithmetic}. {finding.note}".removesuffix(". ").rstrip(".")


def compute(published: Published, config: Mapping[str, Any], results: Results) -> pd.DataFrame:
    """The ledger from its sources."""
    return ledger(published, counterparts(published, config, results))
