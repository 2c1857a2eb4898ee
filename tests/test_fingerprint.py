"""Fingerprints of hosts: the same when asked twice, and other kernels show."""

import json
import os
import subprocess
import sys

import pytest

from repro import contract
from repro.fingerprint import compare_hosts, differing, fingerprint


def elsewhere(**variables):
    """Fingerprint of another process, without the probes that need torch."""
    code = "import json; from repro.fingerprint import fingerprint; print(json.dumps(fingerprint()))"
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, env={**os.environ, **variables}, capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


@pytest.mark.slow
def test_another_process_on_the_same_host_computes_the_same():
    here = fingerprint()
    assert here == fingerprint() == elsewhere()
    assert len(set(here.values())) >= 20  # the two lstsq come from one LAPACK


def test_hosts_that_train_in_another_arithmetic_differ_in_a_probe_of_networks(monkeypatch):
    # Both multiply bfloat16 to the same bytes, but `precision: auto` takes it only where it is native.
    code = (
        "import json; from repro.cnn.network import on_this_processor; "
        "from repro.fingerprint import network_fingerprint; "
        "print(json.dumps([on_this_processor('auto'), network_fingerprint()]))"
    )
    found = []
    for value in ("AVX2", "DEFAULT"):
        monkeypatch.setenv("ONEDNN_MAX_CPU_ISA", value)
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
        found.append(json.loads(done.stdout))
    (limited, probes), (precision, own) = found
    if limited == precision:
        pytest.skip("this processor does not multiply bfloat16")
    assert differing(probes, own) == ["torch native bfloat16"]


def test_a_host_that_computes_the_same_is_inside_the_contract():
    assert "inside the numeric contract" in compare_hosts(fingerprint())
    assert "no fingerprint" in compare_hosts(None)


def test_probes_that_a_run_did_not_record_tell_nothing():
    assert differing({"sum": "a", "dct": "b", "older": "c"}, {"sum": "a", "dct": "x", "svd": "d"}) == ["dct"]


@pytest.mark.slow
@pytest.mark.skipif(not contract.is_v3(), reason="kernels of x86-64")
def test_other_kernels_are_outside_and_named():
    recorded = elsewhere(OPENBLAS_CORETYPE="Nehalem" if os.environ["OPENBLAS_CORETYPE"] != "Nehalem" else "Haswell")
    assert "matmul" in differing(recorded, fingerprint())
    assert "outside the numeric contract" in compare_hosts(recorded)
    assert "matmul" in compare_hosts(recorded)


def test_sums_and_transforms_are_the_same_whatever_the_kernel():
    recorded = elsewhere(OPENBLAS_CORETYPE="Nehalem", NPY_DISABLE_CPU_FEATURES="X86_V3 X86_V4 AVX512_ICL AVX512_SPR")
    assert {"dct", "sum", "einsum", "generator", "sqrt"}.isdisjoint(differing(recorded, fingerprint()))
