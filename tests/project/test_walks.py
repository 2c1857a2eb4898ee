"""The walks of docs/architecture.md: each step exists, each caller refers to what it calls, and the steps are few."""

import ast
import inspect
import re
import textwrap
from importlib import import_module
from operator import attrgetter

import pytest
from experiment_example import ROOT

from repro.cli import COMMANDS
from repro.exhibits.catalogue import EXHIBITS

PAGE = (ROOT / "docs/architecture.md").read_text(encoding="utf-8")
STEP = re.compile(r"^\| `([^`]+)` \| `([^`]+)` \| (.+) \|$", re.MULTILINE)
#: Most steps of a walk.
MAX_STEPS = 10
#: Beginnings of the titles of the walks.
TITLES = ("Table 10", "The interval of a parameter", "The image and its training")
#: Functions that are looked up by their names, and the definitions that look them up.
BY_NAME = {("workflow/rules/exhibits.smk", exhibit.definition) for exhibit in EXHIBITS}
BY_NAME |= {("repro.cli:main", f"{run.__module__}:{run.__name__}") for _, run in COMMANDS.values()}


def walk(title):
    """Return the steps of a walk: caller, called, what happens."""
    (section,) = re.findall(rf"^### ({re.escape(title)}.*?)(?=^##|\Z)", PAGE, re.MULTILINE | re.DOTALL)
    return STEP.findall(section)


def file_of(place):
    """Return the path of a file of the workflow, or of the module of ``module:name``."""
    name = place.partition(":")[0]
    return ROOT / (name if "/" in name else f"src/{name.replace('.', '/')}.py")


def names_in(place):
    """Names that a definition refers to; of a constant, those of its module."""
    module, _, name = place.partition(":")
    whole = import_module(module)
    part = attrgetter(name)(whole)
    source = inspect.getsource(part if inspect.isroutine(part) or inspect.isclass(part) else whole)
    parts = list(ast.walk(ast.parse(textwrap.dedent(source))))
    names = {each.id for each in parts if isinstance(each, ast.Name)}
    names |= {alias.name for each in parts if isinstance(each, ast.ImportFrom) for alias in each.names}
    return names, {each.attr for each in parts if isinstance(each, ast.Attribute)}


def refers(caller, called):
    """Whether a rule names a function, or a definition names another."""
    own, _, rule = caller.partition(":")
    if caller.startswith("workflow/rules/"):
        text = (ROOT / own).read_text(encoding="utf-8")
        block = re.search(rf"^rule {rule}:\n(?:(?!^rule ).*\n)*", text, re.MULTILINE)[0] if rule else text
        return f'"{called}"' in block
    module, _, name = called.partition(":")
    names, attributes = names_in(caller)
    first, *rest = name.split(".")
    if rest:
        return rest[-1] in attributes
    if first not in names:
        return first in attributes
    found = getattr(import_module(own), first, None)  # None where the import is within the function
    return found is None or found is getattr(import_module(module), first)


@pytest.mark.parametrize("title", TITLES)
def test_each_step_of_a_walk_exists_and_is_called(title):
    steps = walk(title)
    assert 5 < len(steps) <= MAX_STEPS
    reached = set()
    for caller, called, what in steps:
        for place in (caller, called):
            assert file_of(place).is_file(), place
            module, _, name = place.partition(":")
            if "/" not in module:
                attrgetter(name)(import_module(module))
        assert caller in reached or not reached or caller.startswith("workflow/rules/"), caller
        by_name = what.startswith("By name") and (caller, called) in BY_NAME
        assert by_name or refers(caller, called), (caller, called)
        reached |= {caller, called}


def test_each_walk_of_the_page_is_tested():
    section = PAGE.partition("\n## Walks\n")[2].partition("\n## ")[0]
    titles = re.findall(r"^### (.+)$", section, re.MULTILINE)
    assert len(titles) == len(TITLES) and all(map(str.startswith, titles, TITLES))
