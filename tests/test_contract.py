"""The numeric contract: what is set, when it is too late, and captures that pass between processors."""

import os
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from repro import contract
from repro.board.capture import read_capture
from repro.board.frames import RADIANS_PER_COUNT
from repro.experiments.arm import check_recorded, program_from_config

from experiment_example import CAPTURES, full_config, refused  # isort: skip


def test_what_the_user_has_set_stays(monkeypatch):
    monkeypatch.delitem(sys.modules, "numpy")
    environment = {"OPENBLAS_CORETYPE": "Zen"}
    contract.hold(environment)
    assert (environment["OPENBLAS_CORETYPE"], environment["OPENBLAS_NUM_THREADS"]) == ("Zen", "1")


def test_a_kernel_that_the_processor_cannot_run_is_not_used(monkeypatch, tmp_path):
    old, new = tmp_path / "old", tmp_path / "new"
    old.write_text("processor : 0\nflags : fpu avx2 fma\n")
    new.write_text("processor : 0\nflags : fpu avx2 fma avx512f avx512vl\n")
    assert [contract.can_run("SkylakeX", cpuinfo) for cpuinfo in (old, new)] == [False, True]
    assert contract.can_run("Zen", old) and contract.can_run("SkylakeX", tmp_path / "none")
    monkeypatch.setattr(contract, "can_run", lambda kernel: kernel != "SkylakeX")
    monkeypatch.setattr(contract, "is_v3", lambda: True)
    environment = {"OPENBLAS_CORETYPE": "SkylakeX", "OPENBLAS_NUM_THREADS": "3"}
    assert set(contract.set_variables(environment)) == set(contract.CONTRACT)
    assert environment == contract.CONTRACT | {"OPENBLAS_NUM_THREADS": "3"}


def test_a_processor_without_the_instructions_is_not_told_to_use_them(monkeypatch, tmp_path):
    monkeypatch.delitem(sys.modules, "numpy")
    (tmp_path / "cpuinfo").write_text("processor : 0\nflags : fpu sse4_2 avx\n")
    (tmp_path / "some").write_text("processor : 0\nflags : fpu avx2 fma bmi1 bmi2 f16c\n")  # no movbe
    assert [name for name in ("cpuinfo", "some", "none") if contract.is_v3(tmp_path / name)] == []
    monkeypatch.setattr(contract, "is_v3", lambda: False)
    environment = {}
    contract.hold(environment)
    assert environment == contract.ONE_THREAD


def test_it_is_too_late_once_numpy_is_loaded():
    with pytest.raises(RuntimeError, match="OPENBLAS_NUM_THREADS"):
        contract.hold({})


def probe(code, **environment):
    """Print of a fresh interpreter."""
    variables = {name: value for name, value in os.environ.items() if name not in contract.CONTRACT} | environment
    command = [sys.executable, "-c", code]
    return subprocess.run(command, env=variables, capture_output=True, text=True, check=True).stdout


SOLVE = """
import os
from repro import contract
contract.hold(os.environ)
import numpy as np
rng = np.random.default_rng(0)
a, b = rng.normal(size=(300, 40)), rng.normal(size=(300, 3))
print(np.linalg.lstsq(a, b)[0].tobytes().hex()[:4000], np.exp(b).tobytes().hex()[:4000])
"""


@pytest.mark.skipif(not contract.is_v3(), reason="the contract is about x86-64-v3")
def test_the_contract_and_nothing_else_decides_the_kernels():
    held = probe(SOLVE)
    assert held == probe(SOLVE, **contract.CONTRACT)
    assert held != probe(SOLVE, OPENBLAS_CORETYPE="Nehalem")


DESIRED = """
import sys
from pathlib import Path
from repro.config.check import load_config
from repro.experiments.arm import program_from_config
config = load_config(Path("config/config.yaml"))
print(*(program_from_config(config, name).q.tobytes().hex() for name in ("ID", "T3")))
"""


@pytest.mark.slow
@pytest.mark.skipif(not contract.is_v3(), reason="Nehalem is of x86-64")
def test_a_motion_computed_on_another_processor_is_the_recorded_one(monkeypatch):
    """Last bits may differ there; in encoder counts it is the same motion, and the capture is accepted."""
    monkeypatch.chdir(CAPTURES.parent.parent)
    config = full_config()
    texts = probe(DESIRED, OPENBLAS_CORETYPE="Nehalem").split()
    for name, text in zip(("ID", "T3"), texts, strict=True):
        program = program_from_config(config, name)
        elsewhere = np.frombuffer(bytes.fromhex(text)).reshape(2, -1)
        assert np.abs(elsewhere - program.q).max() < 1e-6 * RADIANS_PER_COUNT
        check_recorded(read_capture(CAPTURES / f"{name}.bin"), replace(program, q=elsewhere))


@pytest.mark.slow
def test_a_motion_that_is_more_than_a_hundredth_of_a_count_away_is_another():
    capture, program = read_capture(CAPTURES / "T4.bin"), program_from_config(full_config(), "T4")

    def moved(by):
        q = program.q.copy()
        q[1, 100] += by * RADIANS_PER_COUNT
        return replace(program, q=q)

    check_recorded(capture, moved(0.0095))
    for counts in (0.0105, -1.0):
        refused(check_recorded, capture, moved(counts))
