"""Tutorials: scripts in percent format, run cell by cell into a page with their outputs and figures.

A cell begins with ``# %%``, a cell of text with ``# %% [markdown]``; editors and Jupyter open the same files.
"""

import ast
import contextlib
import io
import os
import re
import tempfile
from collections.abc import Iterator
from functools import partial
from pathlib import Path

from matplotlib.figure import Figure

from repro.files import atomic_write, write_text

_HEAD = re.compile(r"^# %%(?P<text> \[markdown\])?.*\n", re.MULTILINE)


def cells(source: str) -> Iterator[tuple[bool, str]]:
    """Split a script into cells: whether it is text, and its content, of text without the comment signs."""
    heads = list(_HEAD.finditer(source))
    ends = [*(head.start() for head in heads[1:]), len(source)]
    for head, end in zip(heads, ends, strict=True):
        content = source[head.end() : end].strip("\n")
        is_text = head["text"] is not None
        yield is_text, re.sub(r"^# ?", "", content, flags=re.MULTILINE) if is_text else content


def run_cell(code: str, name: str, names: dict[str, object]) -> tuple[str, Figure | None]:
    """Run a cell; return what it prints, and its last expression if that is a figure."""
    tree = ast.parse(code, name)
    last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
    value = None
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        exec(compile(tree, name, "exec"), names)
        if isinstance(last, ast.Expr):
            value = eval(compile(ast.Expression(last.value), name, "eval"), names)
    return printed.getvalue(), value if isinstance(value, Figure) else None


def run_tutorial(script: Path, page: Path, logs: str) -> None:
    """Run a script in a temporary folder; write the page, and its figures next to it as ``PAGE-1.png`` and so on.

    Logs of a real arm are in the folder `logs`, which the script finds by the variable ``REPRO_REALDATA``.
    """
    script, page = script.absolute(), page.absolute()
    os.environ["REPRO_REALDATA"] = str(Path(logs).absolute())
    parts = [f"<!-- made from {script.name} by target `tutorials` -->"]
    names: dict[str, object] = {}
    figures = 0
    source = script.read_text(encoding="utf-8")
    with tempfile.TemporaryDirectory() as work, contextlib.chdir(work):
        for is_text, content in cells(source):
            if is_text:
                parts.append(content)
                continue
            parts.append(f"```python\n{content}\n```")
            printed, figure = run_cell(content, script.name, names)
            if printed.strip():
                lines = [line.rstrip() for line in printed.strip("\n").splitlines()]
                parts.append("\n".join(["```text", *lines, "```"]))
            if figure is not None:
                figures += 1
                picture = page.with_name(f"{page.stem}-{figures}.png")
                atomic_write(picture, partial(figure.savefig, dpi=100, metadata={"Software": None}))
                parts.append(f"![Figure {figures}]({picture.name})")
    write_text(page, "\n\n".join(parts) + "\n")
