"""Orthogonalised steps against the polynomial of singular values, and against the library's optimiser."""

import numpy as np
import pytest
import torch

from repro.cnn.train import QUINTIC, QUINTIC_TIMES, Muon, orthogonalised


def lifted(matrix):
    """The polynomial applied to the singular values themselves, in double precision."""
    left, values, right = np.linalg.svd(matrix.double().numpy(), full_matrices=False)
    values /= np.linalg.norm(values)
    for _ in range(QUINTIC_TIMES):
        values = sum(c * values**power for c, power in zip(QUINTIC, (1, 3, 5), strict=True))
    return (left * values) @ right


@pytest.mark.parametrize(("dtype", "tolerance"), [(torch.float32, 1e-4), (torch.bfloat16, 0.03)])
@pytest.mark.parametrize("shape", [(100, 3610), (10, 162), (50, 50), (60, 20), (1, 7)])
@pytest.mark.parametrize("scale", [1e-5, 1.0, 1e4])
def test_singular_values_are_lifted_by_the_polynomial(shape, scale, dtype, tolerance):
    matrix = scale * torch.randn(shape, generator=torch.Generator().manual_seed(0))
    found = orthogonalised(matrix, dtype).double().numpy()
    expected = lifted(matrix)
    assert np.linalg.norm(found - expected) < tolerance * np.linalg.norm(expected)


def test_nothing_stays_nothing():
    assert torch.equal(orthogonalised(torch.zeros(3, 5), torch.float32), torch.zeros(3, 5))


def test_steps_are_those_of_the_library_within_its_bfloat16():
    rng = torch.Generator().manual_seed(2)
    kernel = torch.randn(10, 2, 9, 9, generator=rng)
    own, its = (torch.nn.Parameter(w.clone()) for w in (kernel, kernel.flatten(1)))
    muon = Muon([own], 0.01, torch.float32)
    library = torch.optim.Muon(
        [its], 0.01, weight_decay=0.0, adjust_lr_fn="match_rms_adamw", ns_steps=QUINTIC_TIMES, ns_coefficients=QUINTIC
    )
    for _ in range(20):
        own.grad = torch.randn(kernel.shape, generator=rng)
        its.grad = own.grad.flatten(1)
        muon.step()
        library.step()
    moved = (its - kernel.flatten(1)).norm()
    assert moved > 0.01 * kernel.norm()
    assert (own.flatten(1) - its).norm() < 0.01 * moved


def test_weights_without_a_gradient_stay():
    weight = torch.nn.Parameter(torch.ones(2, 3))
    Muon([weight], 0.1, torch.float32).step()
    assert torch.equal(weight, torch.ones(2, 3))
