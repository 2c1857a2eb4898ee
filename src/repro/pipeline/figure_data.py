"""Numbers drawn in Figures 5, 6, 8, 9 and 11 to 17, as tidy tables."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from repro.cnn.dataset import DataSettings, sample_motion
from repro.cnn.image import assemble, colours, image_factors
from repro.cnn.priors import sample_beta
from repro.model.dynamics import inverse_dynamics, rebuild_torque, regressor
from repro.model.parameters import Array
from repro.pipeline.numeric import motion_of
from repro.pipeline.summary import median_seeds
from repro.settings import NumericSettings
from repro.signals.dct import dct2sub, spectrum
from repro.signals.sampling import SignalSettings
from repro.signals.trajectories import Motion, identification_trajectory
from repro.streams import Stream, stream

Curve = tuple[str, str, Array, Array]


def curves(parts: Iterable[Curve]) -> pd.DataFrame:
    """Tidy table of curves.

    Columns ``panel, series, x, y``.
    """
    frames = [pd.DataFrame({"panel": p, "series": s, "x": x, "y": y}) for p, s, x, y in parts]
    return pd.concat(frames, ignore_index=True)


def subsampling(signals: SignalSettings, beta: Array) -> pd.DataFrame:
    """Figure 5: a torque, its spectrum with the cut, and the subsampled torque."""
    motion = identification_trajectory(signals.duration, signals.h)
    x = inverse_dynamics(motion.q, motion.dq, motion.ddq, beta)[0]
    bands, m = spectrum(x), signals.samples
    k = np.arange(x.size)
    time_sub = (np.arange(m) + 0.5) * x.size / m * signals.h  # the DCT-II samples the middle of each cell
    return curves(
        [
            ("signal", "x", motion.time, x),
            ("spectrum", "kept", k[:m], bands[:m]),
            ("spectrum", "dropped", k[m:], bands[m:]),
            ("subsampled", "xs", time_sub, dct2sub(x, m)),
        ]
    )


def trajectory(motion: Motion) -> pd.DataFrame:
    """Figures 6 and 16: position, velocity and acceleration of both joints."""
    panels = {"position": motion.q, "velocity": motion.dq, "acceleration": motion.ddq}
    return curves((p, f"joint{j + 1}", motion.time, x[j]) for p, x in panels.items() for j in (0, 1))


def example_images(signals: SignalSettings, data: DataSettings, seed: int, count: int = 9) -> pd.DataFrame:
    """Figure 8: images whose guess is right (M_p) and wrong (M_n), in the colours of Eq. 16.

    Each pair shares its torque. Values are clipped to the displayable range.

    Columns ``kind, image, row, column, red, green, blue``.
    """
    rng = stream(seed, Stream.EXAMPLES)
    motion = sample_motion(identification_trajectory(signals.duration, signals.h), signals)
    beta = sample_beta(rng, count, data.prior)
    tau = rebuild_torque(motion.torque, beta)
    largest = np.abs(tau).max((-2, -1), keepdims=True)
    alpha = tau / largest
    guesses = {"Mp": beta / largest[:, 0], "Mn": rng.uniform(data.guess.low, data.guess.high, (count, 9))}
    side = signals.samples
    row, column = (a.ravel() for a in np.meshgrid(np.arange(side), np.arange(side), indexing="ij"))
    frames = []
    for kind, guess in guesses.items():
        u, v = image_factors(alpha, 2 * alpha - rebuild_torque(motion.model, guess), data.image)
        for index, rgb in enumerate(colours(assemble(u, v)).reshape(count, -1, 3)):
            pixels = {"kind": kind, "image": "abcdefghi"[index], "row": row, "column": column}
            pixels |= dict(zip(("red", "green", "blue"), np.round(rgb.T, 4), strict=True))
            frames.append(pd.DataFrame(pixels))
    return pd.concat(frames, ignore_index=True)


def torque_distribution(signals: SignalSettings, data: DataSettings, seed: int, arms: int = 10_000) -> pd.DataFrame:
    """Figure 9: distribution of the training torques, each divided by its largest magnitude."""
    reference = identification_trajectory(signals.duration, signals.h)
    motion = sample_motion(reference, signals)
    tau = rebuild_torque(motion.torque, sample_beta(stream(seed, Stream.TRAINING_ARMS), arms, data.prior))
    tau = tau / np.abs(tau).max((-2, -1), keepdims=True)
    time = (np.arange(signals.samples) + 0.5) * signals.duration / signals.samples
    levels = {f"p{p:02d}": np.percentile(tau, p, axis=0) for p in (5, 25, 50, 75, 95)}
    levels["mean"] = tau.mean(0)
    return curves((f"joint{j + 1}", name, time, y[j]) for j in (0, 1) for name, y in levels.items())


def loss(history: pd.DataFrame) -> pd.DataFrame:
    """Figure 10: training and test loss over the iterations."""
    x = history["step"].to_numpy(dtype=np.float64)
    return curves(("loss", s, x, history[f"{s}_loss"].to_numpy(dtype=np.float64)) for s in ("train", "test"))


def held_out_losses(histories: Mapping[str, pd.DataFrame], batches: Mapping[str, int]) -> pd.DataFrame:
    """Loss on held-out images over the images trained on, of each series by its name."""
    return curves(
        ("loss", name, batches[name] * h["step"].to_numpy(dtype=np.float64), h["test_loss"].to_numpy(dtype=np.float64))
        for name, h in histories.items()
    )


def kernel_spectra(weights: Mapping[str, NDArray[np.floating]]) -> pd.DataFrame:
    """Figure 11: power spectrum of every convolution kernel, zero frequency in the middle.

    Columns ``layer, input, output, row, column, power``.
    """
    frames = []
    for name in ("conv1", "conv2", "conv3"):
        kernels = weights[f"{name}.weight"].astype(np.float64)  # (output, input, k, k)
        power = np.abs(np.fft.fftshift(np.fft.fft2(kernels), axes=(-2, -1))) ** 2
        power /= power.max((-2, -1), keepdims=True)
        index = np.indices(power.shape).reshape(4, -1)
        columns = dict(zip(("output", "input", "row", "column"), index, strict=True))
        frames.append(pd.DataFrame({"layer": name, **columns, "power": power.ravel()}))
    return pd.concat(frames, ignore_index=True)[["layer", "input", "output", "row", "column", "power"]]


def torques(
    identifications: Sequence[Mapping[str, Any]],
    scores: pd.DataFrame,
    signals: SignalSettings,
    numeric: NumericSettings,
    trajectory_name: str,
    cases: Sequence[str],
    method: str = "algorithm1",
    in_frequency: bool = False,
) -> pd.DataFrame:
    """Figures 12 to 15 and 17: actual and rebuilt torque of the median seed."""
    chosen = median_seeds(scores)
    runs = {run["seed"]: run["arms"] for run in identifications}
    parts: list[Curve] = []
    for case in cases:
        seed = chosen[case, method]
        motion = motion_of(trajectory_name, signals, numeric, seed)
        y = regressor(motion.q, motion.dq, motion.ddq)
        arm = runs[seed][case]
        series = {"actual": arm["true"], "rebuilt": arm["methods"][method]["beta"]}
        for j in (0, 1):
            for name, beta in series.items():
                tau = rebuild_torque(y, np.array(beta))[j]
                x = np.arange(tau.size) / (2 * tau.size * signals.h) if in_frequency else motion.time
                parts.append((f"{case}/joint{j + 1}", name, x, spectrum(tau) if in_frequency else tau))
    return curves(parts)
