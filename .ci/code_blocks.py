"""Run the code blocks of the pages and compare their output with what the pages show.

Blocks fenced as ``sh`` and ``python`` are run. A block fenced as ``text`` right after one is its output, in which a
line ``...`` stands for any lines. Each page has a folder of its own with links to the project. A comment before a
block says what is special about it:

| comment | meaning |
|---|---|
| not run: REASON | the block is left out |
| exit code: 2 | the block ends with this code |
| in the background | the block runs until the page ends |
| part of the output above | text that the last block printed, among other text |
| file: NAME | the content of this file |

Python blocks of pages that ``tests/project/test_code_blocks.py`` runs are left to it. Scripts of the tutorials are run
too, and must make the kept pages; that of the real arm only where its logs are.
Usage: ``.venv/bin/python .ci/code_blocks.py [PAGE or SCRIPT ...]``.
"""

import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests/examples"))
from printed import same_output  # noqa: E402
from realdata import NAMES, folder, log_file  # noqa: E402

BLOCK = re.compile(
    r"(?:^<!-- (?P<mark>[^\n]*) -->\n+)?^```(?P<lang>\w+)\n(?P<code>.*?)^```\n(?:\n^```text\n(?P<shown>.*?)^```\n)?",
    re.MULTILINE | re.DOTALL,
)
#: Pages whose Python blocks a test runs, one after another in one process.
TESTED = ("README.md", "docs/use-from-python.md")
#: Seconds that a block may take.
LIMIT = 300
#: Generated or kept elsewhere.
LEFT_OUT = ("docs/reference/",)
TUTORIALS = sorted(ROOT.glob("docs/tutorials/*.py"))
#: Runs a tutorial: script, page, folder of the logs.
RUN_TUTORIAL = """
import os, sys
from pathlib import Path
from repro import contract
contract.hold(os.environ)
from repro.report.tutorial import run_tutorial
run_tutorial(Path(sys.argv[1]), Path(sys.argv[2]), sys.argv[3])
"""


def pages() -> list[Path]:
    """Pages that people write, and the scripts of tutorials."""
    found = [
        ROOT / "README.md",
        ROOT / "CONTRIBUTING.md",
        ROOT / "config/README.md",
        *sorted(ROOT.glob("docs/**/*.md")),
    ]
    found = [page for page in found if not str(page.relative_to(ROOT)).startswith(LEFT_OUT)]
    scripts = TUTORIALS
    if not all(log_file(name).is_file() for name in NAMES):
        print("docs/tutorials/real-arm.py: not run, as the logs of the real arm are not here", flush=True)
        scripts = [script for script in TUTORIALS if script.stem != "real-arm"]
    return found + scripts


def matches(printed: str, shown: str, anywhere: bool = False) -> bool:
    """Whether the parts between lines of dots follow each other in what was printed."""
    lines = [line.strip() for line in printed.splitlines() if line.strip()]
    parts = [part.splitlines() for part in re.split(r"^ *\.\.\. *(?:\n|$)", shown, flags=re.MULTILINE)]
    parts = [[line.strip() for line in part if line.strip()] for part in parts]
    at = 0
    for k, part in enumerate(parts):
        if not part:
            continue
        starts = range(at, len(lines) - len(part) + 1) if k or anywhere else [at]
        start = next((s for s in starts if same_output("\n".join(lines[s : s + len(part)]), "\n".join(part))), None)
        if start is None:
            return False
        at = start + len(part)
    return anywhere or not parts[-1] or at == len(lines)


def run_page(page: Path) -> tuple[int, list[str]]:
    """Number of blocks that ran, and what went wrong."""
    wrong, ran, background, printed = [], 0, [], ""
    name = str(page.relative_to(ROOT))
    environment = {**os.environ, "PATH": f"{ROOT / '.venv/bin'}:{os.environ['PATH']}", "COLUMNS": "120"}
    with tempfile.TemporaryDirectory() as folder:
        for entry in ROOT.iterdir():
            if entry.name not in (".git", "mine", "results", "paper_figures", ".snakemake"):
                (Path(folder) / entry.name).symlink_to(entry)
        for block in BLOCK.finditer(page.read_text(encoding="utf-8")):
            mark, language, code, shown = (block[part] or "" for part in ("mark", "lang", "code", "shown"))
            if mark.startswith("file: "):
                (Path(folder) / mark.removeprefix("file: ")).write_text(code, encoding="utf-8")
            elif mark == "part of the output above" and not matches(printed, code, anywhere=True):
                wrong.append(f"printed\n{printed}\nshown\n{code}")
            if mark.startswith(("not run:", "file: ")) or language not in ("sh", "python"):
                continue
            if language == "python" and name in TESTED:
                continue
            ran += 1
            command = (
                ["bash", "-eu", "-o", "pipefail", "-c", code] if language == "sh" else [sys.executable, "-c", code]
            )
            if mark == "in the background":
                quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
                background.append(
                    subprocess.Popen(command, cwd=folder, env=environment, start_new_session=True, **quiet)
                )
                time.sleep(5)
                continue
            done = subprocess.run(
                command, cwd=folder, env=environment, timeout=LIMIT, text=True, check=False, stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
            )  # fmt: skip
            printed = done.stdout
            expected = int(mark.partition("exit code: ")[2] or 0)
            if done.returncode != expected:
                wrong.append(f"{code}ended with {done.returncode}, expected {expected}:\n{printed[-2000:]}")
            elif shown and not matches(printed, shown):
                wrong.append(f"{code}printed\n{printed}\nshown\n{shown}")
        for process in background:
            os.killpg(process.pid, 15)
            process.wait()
    return ran, wrong


def run_script(script: Path) -> tuple[int, list[str]]:
    """Number of cells of a tutorial that ran, and what differs from the kept page and its figures."""
    kept = ROOT / "docs/reference/tutorials" / f"{script.stem}.md"
    with tempfile.TemporaryDirectory() as out:
        page = Path(out) / kept.name
        done = subprocess.run(
            [sys.executable, "-c", RUN_TUTORIAL, script, page, folder()], timeout=LIMIT, text=True, check=False,
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        )  # fmt: skip
        if done.returncode:
            return 0, [f"ended with {done.returncode}:\n{done.stdout[-2000:]}"]
        made, names = page.read_text(encoding="utf-8"), {each.name for each in page.parent.iterdir()}
    wrong = [] if same_output(made, kept.read_text(encoding="utf-8")) else [f"made\n{made}"]
    if names != {each.name for each in kept.parent.glob(f"{script.stem}*")}:
        wrong.append(f"made {sorted(names)}")
    return made.count("```python"), wrong


def main() -> None:
    """Run every page, or those named."""
    failed = 0
    for page in [Path(name).resolve() for name in sys.argv[1:]] or pages():
        start = time.monotonic()
        ran, wrong = run_page(page) if page.suffix == ".md" else run_script(page)
        failed += len(wrong)
        if ran:
            print(f"{page.relative_to(ROOT)}: {ran} blocks, {time.monotonic() - start:.0f} s", flush=True)
        for text in wrong:
            print(f"error: {page.relative_to(ROOT)}: {text}", flush=True)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
