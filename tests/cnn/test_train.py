"""Training: what a run learns, that it repeats to the bit, that it resumes, and the paper's own schedule."""

import os
import subprocess
import sys
from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import literal
import numpy as np
import pytest
import torch

from repro.cnn import train as training
from repro.cnn.architecture import PaperSchedule, TrainingSettings
from repro.cnn.dataset import DataSettings, Samples, UnmodelledColumns, sample_motion
from repro.cnn.image import assemble
from repro.cnn.network import FactoredCNN, on_this_processor, sigmoid_loss
from repro.cnn.train import QUINTIC, QUINTIC_TIMES, Muon, evaluate, fingerprint, orthogonalised, train
from repro.signals.dct import SignalSettings
from repro.signals.trajectories import identification_trajectory

pytestmark = pytest.mark.slow

SIGNALS = SignalSettings(sampling_period_s=0.02, image_samples=literal.SMALL.image_size)
MOTION = sample_motion(identification_trajectory(SIGNALS.duration_s, SIGNALS.sampling_period_s), SIGNALS)
DATA = DataSettings()

# Checkpoints (20, 40) fall between rows of the history (15, 30, 45, 60); progress is reported at 50 and 60.
SHORT = PaperSchedule(images=40)
STREAMED = TrainingSettings(
    steps=60, batch=8, warmup=5, test_samples=32, log_every=15, checkpoint_every=20, precision="float32", paper=SHORT
)
PAPER = replace(STREAMED, recipe="paper")
BFLOAT16 = replace(STREAMED, precision="bfloat16")
OTHER = replace(STREAMED, seed=2)


def run(settings, checkpoint=None, report=lambda *_: None):
    network, table = train(MOTION, DATA, literal.SMALL, settings, checkpoint, report)
    seconds = table.pop("seconds").to_numpy()
    return SimpleNamespace(network=network, history=table.to_numpy(), seconds=seconds)


@cache
def whole(settings, fraction=training.LAYER1_FRACTION):
    """A run to its end, which several tests compare others with; `fraction` is the one in which layer 1 learns."""
    return run(settings)


def assert_same(first, second):
    assert_same_weights(first, second)
    np.testing.assert_array_equal(first.history, second.history)


def assert_same_weights(first, second):
    for (name, a), b in zip(first.network.named_parameters(), second.network.parameters(), strict=True):
        assert torch.equal(a, b), name


def record_batches(monkeypatch, edit=lambda samples: samples):
    """List every batch of samples that training draws, and edit each before its use."""
    draw, batches = training.draw_samples, []

    def recorded(*arguments):
        batches.append(edit(draw(*arguments)))
        return batches[-1]

    monkeypatch.setattr(training, "draw_samples", recorded)
    return batches


@pytest.mark.parametrize("settings", [STREAMED, PAPER, BFLOAT16], ids=["streamed", "paper", "bfloat16"])
def test_loss_falls(settings):
    history = whole(settings).history
    assert (history[-1, 2:] < 0.85 * history[0, 2:]).all()


def test_another_seed_gives_other_weights():
    first, other = (whole(settings).network.parameters() for settings in (STREAMED, OTHER))
    assert not any(torch.equal(a, b) for a, b in zip(first, other, strict=True) if a.ndim > 1)


def killed(settings, checkpoint):
    def kill(done, total, loss):
        assert (done, total) == (50, 60)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run(settings, checkpoint, kill)
    assert checkpoint.exists()


# Layer 1 of the streamed schedule rests when the run goes on, or still learns; that of the paper's always learns.
@pytest.mark.parametrize(("settings", "fraction"), [(STREAMED, 0.7), (PAPER, 0.15), (BFLOAT16, 0.15)])
def test_run_killed_between_checkpoints_ends_with_the_same_bits(settings, fraction, tmp_path, monkeypatch):
    monkeypatch.setattr(training, "LAYER1_FRACTION", fraction)
    checkpoint = tmp_path / "state.safetensors"
    killed(settings, checkpoint)
    started, load = [], training.load_checkpoint
    monkeypatch.setattr(training, "load_checkpoint", lambda *a: started.append(load(*a)) or started[-1])
    resumed = run(settings, checkpoint)
    assert started[0].step == 40
    assert_same(whole(settings, fraction), resumed)
    assert resumed.seconds[-1] >= started[0].seconds > 0
    assert (np.diff(resumed.seconds) > 0).all()


def test_checkpoint_of_another_run_is_left_aside(tmp_path):
    killed(STREAMED, tmp_path / "state.safetensors")
    assert_same(whole(OTHER), run(OTHER, tmp_path / "state.safetensors"))


def test_a_run_is_another_whatever_changes_its_result():
    usual = {"motion": MOTION, "data": DATA, "network": literal.SMALL, "s": STREAMED}
    changes = [{}, {"data": replace(DATA, prior="uniform")}, {"network": replace(literal.SMALL, maps=3)}]
    changes += [{"s": other} for other in (OTHER, PAPER, BFLOAT16, replace(STREAMED, steps=30))]
    changes += [{"motion": replace(MOTION, **{name: 1.01 * getattr(MOTION, name)})} for name in ("torque", "model")]
    columns = [UnmodelledColumns(*(MOTION.torque * (1 + (j == k)) for j in range(3))) for k in range(4)]
    changes += [{"motion": replace(MOTION, unmodelled=each)} for each in columns]
    assert len({fingerprint(**(usual | change)) for change in changes}) == len(changes)


def test_weights_do_not_depend_on_how_often_progress_is_kept(tmp_path):
    often = replace(STREAMED, log_every=7, checkpoint_every=9)
    first, second = whole(STREAMED), run(often, tmp_path / "state.safetensors")
    assert_same_weights(first, second)
    np.testing.assert_array_equal(second.history[:, 0], [7, 14, 21, 28, 35, 42, 49, 56, 60])
    # The training loss is a mean over the steps since the row before, so both histories hold the same sum.
    spans = np.diff(second.history[:, 0], prepend=0)
    assert (second.history[:, 2] * spans).sum() == pytest.approx((first.history[:, 2] * 15).sum(), rel=1e-12)
    assert second.history[-1, 3] == first.history[-1, 3]


def test_streamed_schedule_draws_fresh_samples_at_every_step(monkeypatch):
    batches = record_batches(monkeypatch)
    run(replace(STREAMED, steps=20))
    assert sorted(len(batch.residual) for batch in batches) == [8] * 20 + [32]
    rows = np.concatenate([batch.residual for batch in batches])
    rows = rows[(rows != 0).any(1)]  # exact guesses all have the label zero
    assert len(np.unique(rows, axis=0)) == len(rows)


def test_streamed_rate_rises_then_falls_to_zero():
    history = run(replace(STREAMED, log_every=1, learning_rate=1e-3, steps=20, warmup=9)).history
    for done, rate in history[:, :2]:
        step = done - 1
        assert rate == pytest.approx(1e-3 * (1.0 - step / 20) * min(1.0, done / 5), rel=1e-12)


def test_paper_schedule_tests_on_a_fifth_that_it_never_trains_on(monkeypatch):
    plain = whole(PAPER)  # before its labels are changed

    def relabel(samples):
        labels = samples.residual.copy()
        labels[32:] += 1
        return replace(samples, residual=labels)

    batches = record_batches(monkeypatch, relabel)
    other = run(PAPER)
    assert_same_weights(plain, other)
    assert other.history[-1, 3] != plain.history[-1, 3]
    rest = Samples(batches[0].u[32:], batches[0].v[32:], batches[0].residual[32:])
    assert evaluate(other.network, rest) == pytest.approx(other.history[-1, 3], rel=1e-6)


def test_paper_schedule_follows_the_published_rate():
    assert (PaperSchedule().images, PaperSchedule().train_share) == (10_000, 0.8)
    history = whole(PAPER).history
    np.testing.assert_allclose(history[:, 1], 20e-3 + 0.2e-7 * (history[:, 0] - 1), rtol=1e-13)


def test_paper_schedule_takes_the_step_of_gradient_descent(monkeypatch):
    """w - eta MT dL/dw, worked out with the plain network; all images are one, so any batch is that image."""
    batches = record_batches(
        monkeypatch, lambda s: Samples(*(np.repeat(x[:1], len(x), 0) for x in (s.u, s.v, s.residual)))
    )
    schedule = replace(PAPER.paper, learning_rate_slope=0.01)
    trained = run(replace(PAPER, steps=2, paper=schedule))
    sample = batches[0]
    torch.manual_seed(PAPER.seed)
    plain = literal.plain_twin(FactoredCNN(literal.SMALL))
    image = torch.from_numpy(assemble(sample.u[:1], sample.v[:1])).double()
    label = torch.from_numpy(sample.residual[:1]).double()
    for step in range(2):
        plain.zero_grad()
        sigmoid_loss(plain(image), label, 1.0).backward()
        with torch.no_grad():
            for p in plain.parameters():
                p.sub_((20e-3 + 0.01 * step) * 100 * p.grad)
    for ours, right in zip(trained.network.parameters(), plain.parameters(), strict=True):
        torch.testing.assert_close(ours.double(), right, rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize(("dtype", "tolerance"), [(torch.float32, 1e-5), (torch.bfloat16, 5e-3)])
def test_evaluation_is_the_mean_loss_whatever_the_batch(dtype, tolerance):
    network = literal.untrained()
    network.dtype = dtype
    samples = training.draw_samples(np.random.default_rng(0), 13, MOTION, DATA)
    twin = literal.plain_twin(network)
    found = twin(torch.from_numpy(assemble(samples.u, samples.v)).double())
    expected = float(sigmoid_loss(found, torch.from_numpy(samples.residual).double(), 1.0).detach())
    for batch in (1, 5, 64):
        assert evaluate(network, samples, batch) == pytest.approx(expected, rel=tolerance)


@pytest.mark.parametrize(("flags", "onednn"), [({}, True), ({"avx512_bf16": True}, False)])
def test_without_bfloat16_or_onednn_training_is_in_single_precision(monkeypatch, flags, onednn):
    monkeypatch.setattr(torch.cpu, "get_capabilities", lambda: flags)
    monkeypatch.setattr(torch.backends.mkldnn, "is_available", lambda: onednn)
    assert [on_this_processor(name) for name in ("auto", "bfloat16")] == ["float32", "bfloat16"]


def test_a_limit_set_for_onednn_is_respected():
    code = "from repro.cnn.network import on_this_processor; print(on_this_processor('auto'))"
    limited = {**os.environ, "ONEDNN_MAX_CPU_ISA": "AVX2"}
    assert subprocess.check_output([sys.executable, "-c", code], env=limited, text=True).strip() == "float32"


@pytest.mark.parametrize(("dtype", "tolerance"), [(torch.float32, 1e-4), (torch.bfloat16, 0.03)])
@pytest.mark.parametrize(
    ("shape", "scale"), [((100, 3610), 1.0), ((10, 162), 1e-5), ((50, 50), 1e4), ((60, 20), 1.0), ((1, 7), 1e4)]
)
def test_singular_values_are_lifted_by_the_polynomial(shape, scale, dtype, tolerance):
    matrix = scale * torch.randn(shape, generator=torch.Generator().manual_seed(0))
    left, values, right = np.linalg.svd(matrix.double().numpy(), full_matrices=False)
    values /= np.linalg.norm(values)
    for _ in range(QUINTIC_TIMES):
        values = sum(c * values**power for c, power in zip(QUINTIC, (1, 3, 5), strict=True))
    expected, found = (left * values) @ right, orthogonalised(matrix, dtype).double().numpy()
    assert np.linalg.norm(found - expected) < tolerance * np.linalg.norm(expected)
    assert not orthogonalised(0.0 * matrix, dtype).any()


def test_steps_are_those_of_the_library_within_its_bfloat16():
    rng = torch.Generator().manual_seed(2)
    kernel = torch.randn(10, 2, 9, 9, generator=rng)
    own, its = (torch.nn.Parameter(w.clone()) for w in (kernel, kernel.flatten(1)))
    muon = Muon([own], 0.01, torch.float32)
    polynomial = {"ns_steps": QUINTIC_TIMES, "ns_coefficients": QUINTIC}
    library = torch.optim.Muon([its], 0.01, weight_decay=0.0, adjust_lr_fn="match_rms_adamw", **polynomial)
    for _ in range(20):
        own.grad = torch.randn(kernel.shape, generator=rng)
        its.grad = own.grad.flatten(1)
        muon.step()
        library.step()
    moved = (its - kernel.flatten(1)).norm()
    assert moved > 0.01 * kernel.norm()
    assert (own.flatten(1) - its).norm() < 0.01 * moved
