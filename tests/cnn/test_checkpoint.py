"""Weights and training state on disk: round trips, and one line for every file that will not do."""

import literal
import numpy as np
import pytest
import torch
from safetensors.torch import load_file, save_file

from repro.cnn.architecture import NetworkSettings
from repro.cnn.network import load_network, save_network
from repro.cnn.train import Progress, load_checkpoint, save_checkpoint
from repro.errors import InputError

pytestmark = pytest.mark.slow

OTHER_SIZES = NetworkSettings(image_size=44, maps=4, hidden=(16, 7))


@pytest.fixture
def weights(tmp_path):
    path = tmp_path / "cnn.safetensors"
    save_network(path, literal.untrained(), {"variant": "published"})
    return path


def test_network_comes_back_as_it_was(weights):
    saved, loaded = literal.untrained(), load_network(weights, literal.SMALL)
    for (name, a), b in zip(saved.state_dict().items(), loaded.state_dict().values(), strict=True):
        assert torch.equal(a, b), name
    assert loaded.dtype == torch.float32
    assert load_network(weights, literal.SMALL, precision="bfloat16").dtype == torch.bfloat16
    assert not any(p.requires_grad for p in loaded.parameters())
    u, v = (torch.from_numpy(x).float() for x in np.random.default_rng(0).normal(size=(2, 3, 2, 2, 44)))
    assert torch.equal(saved(u, v), loaded(u, v))


def test_a_network_that_says_it_is_another_is_refused(weights):
    assert load_network(weights, literal.SMALL, "published")
    with pytest.raises(InputError, match=r"cnn\.safetensors: header: found published, expected tracked"):
        load_network(weights, literal.SMALL, "tracked")


def change(name, edit):
    """A change of one tensor of a file."""

    def changed(path):
        tensors = load_file(path)
        tensors[name] = edit(tensors.get(name))
        save_file({key: value for key, value in tensors.items() if value is not None}, path)

    return changed


def filled(weight):
    weight[3, 5] = np.nan
    return weight


@pytest.mark.parametrize(
    ("damage", "settings", "words"),
    [
        (lambda path: path.unlink(), literal.SMALL, "safetensors"),
        (lambda path: path.write_bytes(b""), literal.SMALL, "safetensors"),
        (lambda path: path.write_bytes(b"not weights at all\n" * 20), literal.SMALL, "safetensors"),
        (lambda _: None, OTHER_SIZES, "fc5.bias: found (8,), expected shape (7,)"),
        (change("conv3.bias", lambda _: None), literal.SMALL, "conv3.bias"),
        (change("conv3.scale", lambda _: torch.ones(4)), literal.SMALL, "conv3.scale"),
        (change("fc4.weight", filled), literal.SMALL, "fc4.weight: found a weight that is not finite"),
    ],
)
def test_weights_that_will_not_do_are_refused_in_one_line(weights, damage, settings, words):
    damage(weights)
    with pytest.raises(InputError, match=r": found .*, expected ") as caught:
        load_network(weights, settings)
    message = str(caught.value)
    assert "\n" not in message
    assert message.startswith(str(weights))
    assert words in message


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
    with pytest.raises(InputError) as caught:
        load_checkpoint(path, literal.untrained(), [], "run")
    assert "\n" not in str(caught.value)
