"""The factored network against the plain one of Fig. 7, the loss of Section IV-B, and weights on disk."""

from dataclasses import replace

import literal
import numpy as np
import pytest
import torch
import torch.nn.functional as F  # noqa: N812
from experiment_example import refused
from hypothesis import given
from hypothesis import strategies as st
from safetensors.torch import load_file, save_file
from strategies import seeds

from repro.cnn.architecture import NetworkSettings
from repro.cnn.dataset import DataSettings, draw_samples, sample_motion
from repro.cnn.image import assemble
from repro.cnn.network import PIECE, FactoredCNN, estimate_residuals, load_network, save_network, sigmoid_loss
from repro.cnn.reader import PIECE as READ_AT_A_TIME
from repro.cnn.reader import Reader
from repro.cnn.train import Progress, load_checkpoint, save_checkpoint
from repro.signals.dct import SignalSettings
from repro.signals.trajectories import identification_trajectory

PUBLISHED = NetworkSettings()


def pair(sizes, precision="float32", seed=0):
    """Plain and factored network with the same weights; biases not zero."""
    torch.manual_seed(seed)
    plain = literal.SignalCNN(sizes)
    for layer in plain.children():
        torch.nn.init.normal_(layer.bias, std=0.1)
    factored = FactoredCNN(sizes, precision)
    factored.load_state_dict(plain.state_dict())
    if precision == "float64":
        plain.double(), factored.double()
    return plain, factored


def factors(seed, n, side, dtype=torch.float64):
    """Smooth random factors."""
    rng = np.random.default_rng(seed)
    wave = np.cumsum(rng.normal(size=(2, n, 2, 2, side)), -1) / np.sqrt(side)
    u, v = (torch.from_numpy(x).to(dtype) for x in wave)
    return u, v


def gradients(network, residual, weights):
    network.zero_grad()
    (residual * weights).sum().backward()
    return {name: p.grad.clone() for name, p in network.named_parameters()}


OTHER = literal.Sizes(hidden=(5, 6), image_size=60, maps=3, kernels=(7, 4, 2))


@pytest.mark.parametrize(("sizes", "seed"), [*((literal.SMALL, k) for k in range(20)), (PUBLISHED, 0), (OTHER, 0)])
def test_outputs_and_gradients_of_the_factored_network_are_those_of_the_plain_one(sizes, seed):
    plain, factored = pair(sizes, "float64", seed)
    u, v = factors(seed, 3, sizes.image_size)
    weights = torch.from_numpy(np.random.default_rng(seed).normal(size=(3, 9)))
    expected, found = plain(torch.from_numpy(assemble(u.numpy(), v.numpy()))), factored(u, v)
    assert (found.dtype, found.shape) == (u.dtype, (3, 9))
    assert (found - expected).abs().max() <= 1e-10 * expected.abs().max()
    right, ours = gradients(plain, expected, weights), gradients(factored, found, weights)
    assert ours.keys() == right.keys()
    for name, gradient in right.items():
        assert gradient.abs().max() > 0
        assert (ours[name] - gradient).abs().max() <= 1e-10 * gradient.abs().max(), name


def test_bfloat16_gradients_point_the_same_way():
    """Eight bits of mantissa, 0.4 % a rounding: outputs to 2 % of the largest, gradients to a cosine of 0.98."""
    plain, factored = pair(PUBLISHED, "bfloat16")
    signals = SignalSettings()
    motion = sample_motion(identification_trajectory(signals.duration_s, signals.sampling_period_s), signals)
    samples = draw_samples(np.random.default_rng(0), 16, motion, DataSettings())
    u, v, label = torch.from_numpy(samples.u), torch.from_numpy(np.array(samples.v)), torch.from_numpy(samples.residual)
    expected, found = plain(torch.from_numpy(assemble(samples.u, samples.v))), factored(u, v)
    assert found.dtype == torch.float32
    assert 0 < (found - expected).abs().max() <= 0.02 * expected.abs().max()
    for residual in (expected, found):
        sigmoid_loss(residual, label, 1.0).backward()
    for (name, right), ours in zip(plain.named_parameters(), factored.parameters(), strict=True):
        assert ours.grad.dtype == torch.float32
        assert torch.cosine_similarity(right.grad.flatten(), ours.grad.flatten(), 0) > 0.98, name
        assert 0.9 < ours.grad.norm() / right.grad.norm() < 1.1, name


@pytest.mark.parametrize("sizes", [PUBLISHED, literal.SMALL])
@pytest.mark.parametrize(("precision", "tolerance"), [("bfloat16", 0.02), ("float32", 1e-5), ("float64", 1e-12)])
def test_images_of_one_torque_and_a_first_layer_that_learns_no_more_give_the_same(sizes, precision, tolerance):
    n = PIECE + 1
    _, factored = pair(sizes, precision)
    u, v = factors(0, n, sizes.image_size, getattr(torch, precision))
    learning, alone = factored(u, v).detach(), factored(u, v[:1].expand(n, -1, -1, -1)).detach()
    factored.requires_grad_(False)
    for found, expected in ((factored(u, v), learning), (factored(u, v[:1]), alone)):
        assert found.shape == (n, 9)
        assert (found - expected).abs().max() <= tolerance * expected.abs().max()


@pytest.mark.parametrize("sizes", [PUBLISHED, OTHER])
def test_residuals_of_images_are_those_of_their_factors(sizes):
    _, factored = pair(sizes)
    u, v = factors(2, 6, sizes.image_size, torch.float32)
    images = assemble(u.numpy(), v.numpy())
    found = estimate_residuals(factored, images.reshape(3, 2, *images.shape[1:]))
    expected = factored(u, v).detach().numpy().reshape(3, 2, 9)
    assert abs(found - expected).max() <= 1e-5 * abs(expected).max()


@pytest.mark.parametrize("sizes", [PUBLISHED, literal.SMALL, OTHER])
@pytest.mark.parametrize(("precision", "tolerance"), [("bfloat16", 0.03), ("float32", 1e-5), ("float64", 1e-12)])
def test_reader_of_one_torque_is_the_plain_network(sizes, precision, tolerance):
    """In pieces that are full or not, and again after others, though all use the same buffers."""
    plain, factored = pair(sizes, precision)
    u, v = factors(1, 2 * READ_AT_A_TIME + 3, sizes.image_size, torch.promote_types(factored.dtype, torch.float32))
    images = assemble(u.numpy(), v[:1].expand_as(u).numpy())
    expected, read = plain(torch.from_numpy(images)).detach(), Reader(factored, v[0])
    for some in (slice(None), slice(3), slice(1, None), slice(0)):
        found = read(u[some])
        assert (found.shape, found.dtype) == (expected[some].shape, expected.dtype)
        assert ((found - expected[some]).abs() <= tolerance * expected.abs().max()).all()


@pytest.mark.parametrize("tied", ["conv1", "conv2"])
def test_tied_pixels_of_a_pool_share_its_gradient(tied, monkeypatch):
    """As those of `torch.amax` do; with an empty kernel every pool of its map ties."""
    plain, network = pair(literal.SMALL, "float64")
    u, v = factors(0, 3, literal.SMALL.image_size)
    image, weights = torch.from_numpy(assemble(u.numpy(), v.numpy())), torch.ones(3, 9)
    with torch.no_grad():
        getattr(plain, tied).weight[0] = 0.0
        getattr(plain, tied).bias[0] = 1.0
    network.load_state_dict(plain.state_dict())
    one_winner = gradients(plain, plain(image), weights)
    monkeypatch.setattr(F, "max_pool2d", lambda x, side: x.unfold(2, side, side).unfold(3, side, side).amax((4, 5)))
    shared = gradients(plain, plain(image), weights)
    for name, found in gradients(network, network(u, v), weights).items():
        assert (found - shared[name]).abs().max() <= 1e-10 * shared[name].abs().max(), name
    change = (one_winner[f"{tied}.weight"] - shared[f"{tied}.weight"])[0].abs().max()
    assert change > 1e-3 * shared[f"{tied}.weight"][0].abs().max()


@pytest.mark.parametrize(
    "wrong", [{"image_size": 101}, {"image_size": 12}, {"kernels": (9, 4, 3)}, {"kernels": (99, 5, 3)}]
)
def test_sizes_that_leave_no_even_map_are_refused(wrong):
    with pytest.raises(ValueError, match="kernels"):
        FactoredCNN(literal.Sizes(**wrong))


@given(seeds, st.floats(0.1, 5.0))
def test_loss_is_the_printed_formula(seed, gain):
    residual, label = np.random.default_rng(seed).normal(size=(2, 4, 9))
    y_cnn, y_d = 1 / (1 + np.exp(-gain * residual)), 1 / (1 + np.exp(-gain * label))
    of_each = ((y_d - y_cnn) ** 2).sum(axis=1) / 18
    found = sigmoid_loss(torch.from_numpy(residual), torch.from_numpy(label), gain)
    assert float(found) == pytest.approx(of_each.mean(), rel=1e-12)


@pytest.fixture
def weights(tmp_path):
    path = tmp_path / "cnn.safetensors"
    save_network(path, literal.untrained(), {"variant": "published"})
    return path


def test_network_comes_back_as_it_was(weights):
    saved, loaded = literal.untrained(), load_network(weights, literal.SMALL, "published")
    assert loaded.dtype == torch.float32
    assert load_network(weights, literal.SMALL, precision="bfloat16").dtype == torch.bfloat16
    assert not any(p.requires_grad for p in loaded.parameters())
    u, v = (torch.from_numpy(x).float() for x in np.random.default_rng(0).normal(size=(2, 3, 2, 2, 44)))
    assert torch.equal(saved(u, v), loaded(u, v))


def changed(path, more, fewer=None):
    save_file({name: weight for name, weight in (load_file(path) | more).items() if name != fewer}, path)


ONE_NAN = {"fc4.weight": torch.where(torch.arange(16 * 100).view(16, 100) == 305, np.nan, 0.1)}


@pytest.mark.parametrize(
    ("damage", "settings", "fact", "place", "found"),
    [
        (lambda path: path.unlink(), literal.SMALL, None, "", ""),
        (lambda path: path.write_bytes(b""), literal.SMALL, None, "", ""),
        (lambda path: path.write_bytes(b"not weights at all\n" * 20), literal.SMALL, None, "", ""),
        (lambda _: None, replace(literal.SMALL, hidden=(16, 7)), None, "fc5.bias", "(8,)"),
        (lambda _: None, literal.SMALL, "tracked", "header", "published"),
        (lambda path: changed(path, {}, "conv3.bias"), literal.SMALL, None, "conv3.bias", ""),
        (lambda path: changed(path, {"conv3.scale": torch.ones(4)}), literal.SMALL, None, "conv3.scale", ""),
        (lambda path: changed(path, ONE_NAN), literal.SMALL, None, "fc4.weight", "a weight that is not finite"),
        (lambda path: changed(path, {"fc5.bias": torch.full((8,), -np.inf)}), literal.SMALL, None, "fc5.bias", "a"),
    ],
)
def test_weights_that_will_not_do_are_refused_in_one_line(weights, damage, settings, fact, place, found):
    damage(weights)
    error = refused(load_network, weights, settings, fact)
    assert error.place == f"{weights}: {place}".removesuffix(": ") and error.found.startswith(found)


def test_same_network_gives_the_same_file(weights, tmp_path):
    again = tmp_path / "again" / "cnn.safetensors"
    save_network(again, literal.untrained(), {"variant": "published"})
    assert again.read_bytes() == weights.read_bytes()
    assert sorted(p.name for p in tmp_path.iterdir()) == ["again", "cnn.safetensors"]


@pytest.mark.parametrize("keep", [0, 100, -1])
def test_truncated_checkpoint_is_refused(tmp_path, keep):
    path = tmp_path / "state.safetensors"
    save_checkpoint(path, literal.untrained(), [], Progress(2), "run")
    path.write_bytes(path.read_bytes()[:keep])
    refused(load_checkpoint, path, literal.untrained(), [], "run")
