"""Stages that hold our results against the paper's numbers: the ledger and its verification."""

import logging
from pathlib import Path

from repro.errors import InputError
from repro.files import write_text
from repro.paper.claims import broken
from repro.paper.ledger.text import summary
from repro.paper.ledger.verification import verify_ledger, write_ledger
from repro.pipeline.named import Config, Named, paths

_LOG = logging.getLogger(__name__)


def make_claims(output: str, named_inputs: Named, config: Config) -> None:
    """Stage claims: the ledger and the check sums of every input; broken promises are written down too."""
    write_ledger(Path(output).parent, config, [path for files in paths(named_inputs).values() for path in files])


def verify_claims(output: str, config: Config) -> None:
    """Stage verify: check the ledger against its sources, and its promises if the configuration enforces them."""
    results = Path(output).parent
    claims, problems = verify_ledger(results, config)
    for problem in problems:
        _LOG.error("%s", problem)
    if problems or claims is None:
        raise InputError.at(
            f"{results}: ledger", f"{len(problems)} disagreements with its sources, named above", "none"
        )
    lines = summary(claims)
    failed = len(broken(claims))
    if failed and config["claims"]["enforce"]:
        for line in lines:
            _LOG.error("%s", line)
        raise InputError.at(f"{results}/claims.csv: must", f"{failed} promises that do not hold", "none")
    write_text(Path(output), "".join(f"{line}\n" for line in lines))
