"""Pages, help texts and messages avoid the phrases that readers stumbled over most."""

import argparse
import ast
import re

import pytest
from experiment_example import ROOT

from repro.cli import parser

#: Phrases, and what to write instead.
AVOID = {
    r"\b(?:un)?told\b|\bforet(?:old|ells?)\b": "reported, distinguished, predicted",
    r"\btells? (?:nothing|little|of)\b": "does not determine, shows",
    r"\b(?:is|are) said to\b|\bas said\b": "is reported, is stated",
    r"\bvouch\w*": "verifies",
    r"\bput right\b": "corrected",
    r"\b(?:hangs?|hung) on\b": "depends on",
    r"\bbeside\b": "next to, in addition to",
    r"\basks? for\b": "requires, requests",
    r"\b(?:other|another|literal|each|every|three|two|one) readings?\b|\breadings? of the paper\b": "interpretation",
    r"\bpromises?\b|\bpromised\b": "asserted claim",
    r"\b(?:recipes?|versions?|runs?) ago\b|\bas (?:tried first|before)\b|\bformerly\b": "the present state",
    r"\(\d[\d., %]* before\)|\binstead of the old\b|\bat first it\b": "the present state",
    r"kg m\^2/s\^2": "N m",
    r"\bdoubt the\b|\bsame hat\b|\bfor ever\b|\bby luck\b|\bby a hair\b": "the measurement",
}
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "config/README.md", ROOT / "benchmarks/README.md"]
PAGES += [page for page in sorted((ROOT / "docs").rglob("*.md")) if ROOT / "docs/reference" not in page.parents]


def found(text):
    """Avoided phrases of a text, each with what to write."""
    hits = ((match[0], instead) for what, instead in AVOID.items() for match in re.finditer(what, text, re.I))
    return [f"{phrase!r}: write {instead}" for phrase, instead in hits]


def messages(path):
    """Strings of a module with blanks, without its docstrings."""
    nodes = list(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))
    alone = {id(node.value) for node in nodes if isinstance(node, ast.Expr)}
    strings = [node.value for node in nodes if isinstance(node, ast.Constant) and id(node) not in alone]
    return [string for string in strings if isinstance(string, str) and " " in string]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_pages(page):
    assert not found(page.read_text(encoding="utf-8"))


def test_help_texts_and_messages():
    (subcommands,) = (action for action in parser()._actions if isinstance(action, argparse._SubParsersAction))
    texts = [" ".join(command.format_help().split()) for command in subcommands.choices.values()]
    texts += [text for path in sorted((ROOT / "src/repro").rglob("*.py")) for text in messages(path)]
    assert len(texts) > 1000
    assert not [(text, hits) for text in texts if (hits := found(text))]
