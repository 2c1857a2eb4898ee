"""A fingerprint of how this host computes: hashes of some twenty small results tell hosts apart by last bits."""

import hashlib
import json
import math
from collections.abc import Mapping

import numpy as np
import scipy.fft
import scipy.linalg

#: Beginning of the names of the probes that networks are made of.
OF_NETWORKS = "torch"


def fingerprint() -> dict[str, str]:
    """First sixteen digits of the SHA-256 of each result's bytes, by its name."""
    rng = np.random.default_rng(2026)
    x = rng.uniform(-3.0, 3.0, 4099)
    a, b = rng.normal(size=(257, 9)), rng.normal(size=257)
    square = a.T @ a
    wide = rng.normal(size=(130, 131))
    results: dict[str, object] = {
        "generator": rng.bit_generator.state["state"]["state"].to_bytes(16, "big"),
        "libm sin exp log": np.array([f(abs(v)) for v in x[:500] for f in (math.sin, math.exp, math.log)]),
        "exp": np.exp(x),
        "log": np.log(np.abs(x)),
        "sin": np.sin(x),
        "tanh": np.tanh(20.0 * x),
        "arctan2": np.arctan2(x[:-1], x[1:]),
        "power": np.abs(x) ** 0.4,
        "exp single": np.exp(x.astype(np.float32)),
        "sqrt": np.sqrt(np.abs(x)),
        "sum": x.sum(),
        "einsum": np.einsum("ni,nj->ij", a, a),
        "dot": x @ x,
        "matmul": wide @ wide.T,
        "matmul single": wide.astype(np.float32) @ wide.T.astype(np.float32),
        "solve": np.linalg.solve(square, a[0]),
        "lstsq": np.linalg.lstsq(a, b)[0],
        "svd": np.linalg.svd(a, compute_uv=False),
        "eigh": np.linalg.eigvalsh(square),
        "scipy lstsq": scipy.linalg.lstsq(a, b)[0],
        "scipy cholesky": scipy.linalg.cholesky(square),
        "dct": scipy.fft.dct(x, norm="ortho"),
    }
    return {name: _digest(result) for name, result in results.items()}


def _digest(result: object) -> str:
    content = result if isinstance(result, bytes) else np.ascontiguousarray(result).tobytes()
    return hashlib.sha256(content).hexdigest()[:16]


def network_fingerprint() -> dict[str, str]:
    """The same of what networks are made of; loads torch."""
    import torch  # noqa: PLC0415 - a second that most callers need not wait

    generator = torch.Generator().manual_seed(2026)
    x, kernel = torch.randn(8, 4, 33, 35, generator=generator), torch.randn(6, 4, 5, 5, generator=generator)
    rows = x.flatten(1)

    weight = kernel.clone().requires_grad_()
    torch.nn.functional.conv2d(x, weight).square().sum().backward()  # type: ignore[no-untyped-call]
    assert weight.grad is not None  # just computed
    half = rows.bfloat16()
    # What `precision: auto` follows: an emulated product has the same bytes, but networks are then trained in float32.
    able = [name for name in ("avx512_bf16", "amx_bf16", "bf16") if torch.cpu.get_capabilities().get(name)]
    has_onednn = torch.backends.mkldnn.is_available()  # type: ignore[no-untyped-call]
    native = [*able, has_onednn and torch.ops.mkldnn._is_mkldnn_bf16_supported()]
    return {
        f"{OF_NETWORKS} native bfloat16": _digest(json.dumps(native).encode()),
        f"{OF_NETWORKS} randn": _digest(x.numpy()),
        f"{OF_NETWORKS} sigmoid": _digest(torch.sigmoid(x).numpy()),
        f"{OF_NETWORKS} matmul": _digest((rows @ rows.mT).numpy()),
        f"{OF_NETWORKS} matmul bfloat16": _digest((half @ half.mT).float().numpy()),
        f"{OF_NETWORKS} conv gradient": _digest(weight.grad.numpy()),
    }


def differing(recorded: Mapping[str, str], here: Mapping[str, str]) -> list[str]:
    """Probes that both have and that differ."""
    return [name for name in here if name in recorded and recorded[name] != here[name]]


def compare_hosts(recorded: Mapping[str, str] | None) -> str:
    """Report in one line whether this host computes as the one that made a run."""
    if not recorded:
        return "this host: the run keeps no fingerprint to compare with"
    here = fingerprint()
    n, apart = len(here), differing(recorded, here)
    if not apart:
        return f"this host: inside the numeric contract, {n} of {n} probes as where the run was made"
    found = f"outside the numeric contract, {len(apart)} of {n} probes differ ({', '.join(apart)})"
    return f"this host: {found}: computed numbers agree to rounding, not to the bit"


def main() -> None:
    """Print the whole fingerprint as JSON: run in a process of its own, which the contract holds."""
    print(json.dumps(fingerprint() | network_fingerprint()))


if __name__ == "__main__":
    main()
