"""Build the site of the pages: copy them with what they link to, render the copy, and check that it is self-contained.

Usage, in an environment with mkdocs-material: ``python docs/build_site.py``, or ``make site``. It writes build/site.
"""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SOURCE, SITE = ROOT / "build/site-source", ROOT / "build/site"
LINK = re.compile(r"\]\((?!https?:|mailto:|#)([^)#\s]+)")
#: Scripts, styles, fonts and pictures that a browser would fetch from elsewhere.
FOREIGN = re.compile(r"""<(?:script|link|img|iframe)\b[^>]*\b(?:src|href)=["']?(?:https?:)?//[^>]*>""")


def linked(page: Path) -> set[Path]:
    """Files that a page links to."""
    return {(page.parent / target).resolve() for target in LINK.findall(page.read_text(encoding="utf-8"))}


def reachable() -> set[Path]:
    """Pages and files that a reader of README.md can reach by links, each of them in the project."""
    found, waiting = set(), {ROOT / "README.md"}
    while waiting:
        path = waiting.pop()
        if not path.is_file():
            sys.exit(f"error: {path.relative_to(ROOT)}: found no such file, expected one, since a page links to it")
        found.add(path)
        waiting |= (linked(path) if path.suffix == ".md" else set()) - found
    return found


def build() -> None:
    """Copy, render, check."""
    shutil.rmtree(SOURCE, ignore_errors=True)
    for path in reachable():
        copy = SOURCE / path.relative_to(ROOT)
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(path, copy)
    shutil.copytree(ROOT / "docs/site", SOURCE / "site")
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--config-file", "docs/mkdocs.yml"]
    subprocess.run(command, cwd=ROOT, check=True, env={**os.environ, "NO_MKDOCS_2_WARNING": "1"})
    pages = sorted(SITE.rglob("*.html"))
    foreign = [(page.name, tag) for page in pages for tag in FOREIGN.findall(page.read_text(encoding="utf-8"))]
    if foreign:
        sys.exit(f"error: {foreign[0][0]}: found {foreign[0][1]}, expected nothing from another host")
    print(f"{len(pages)} pages in {SITE.relative_to(ROOT)}: open {SITE.relative_to(ROOT)}/index.html")


if __name__ == "__main__":
    build()
