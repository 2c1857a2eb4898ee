# %% [markdown]
# # One guess through the network
#
# [Algorithm 1](../../explanation/algorithm1.md) repeats five steps: guess, image, residual, corrected guess, score.
# This page performs each step once with public names of `repro`. We chose a guess whose corrected parameters are all
# nonnegative, because line 22 of Algorithm 1 rejects others. The guess has parameters of at most 1. The page needs the
# extra `cnn` and a checkout of the project after `make setup`. The project's recordings are **simulated**.
#
# ## Signals
#
# The input of the network comes from 100 samples of the recorded identification motion (Eq. 10), filtered as in the
# paper (Eq. 14). `h` is the sampling period, `c_f` the constant of the filter. Samples `n1` to `n2` - 1 are the
# trajectory of Eq. 10.

# %%
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import yaml

import repro

NAMES = ["I1", "I2", "I3", "g1", "g2", "b1", "b2", "k1", "k2"]
DATA = Path(repro.__file__).parents[2] / "data"
capture = repro.read_capture(DATA / "captures/ID.bin").metadata
run, h, c_f = repro.read_log(DATA / "captures/ID.bin"), capture.h, 1e-4
dq = repro.differentiate(run.q, h, c_f)
signals = np.stack([run.q, dq, repro.differentiate(dq, h, c_f), repro.low_pass(run.tau, h, c_f)])
trajectory = signals[..., capture.n1 : capture.n2]
samples = np.linspace(0, trajectory.shape[-1] - 1, 100).astype(int)
q, dq, ddq, tau = trajectory[..., samples]
scale = abs(tau).max()

# %% [markdown]
# ## Guess, image, residual, corrected guess
#
# A guess is in units of the largest torque. The image compares the torque of the guess with the measured torque (Eq. 8
# and 9). From the image, the network estimates the *residual*, the paper's word for the correction that is added to the
# guess.

# %%
network = repro.load_network(DATA / "networks/cnn.safetensors")
guess = np.random.default_rng(226).uniform(0.001, 1.0, 9)  # passes line 22, below; Algorithm 1 goes up to 3
image = repro.images(q, dq, ddq, tau, guess)
residual = repro.estimate_residuals(network, image)
corrected = guess + residual
for name, values in {"guess": guess, "residual": residual, "corrected": corrected}.items():
    print(f"{name:10}", values.round(2))

# %% [markdown]
# ## Score
#
# The score of each joint is the [similarity](../../explanation/metric.md) of the measured torque and the torque of the
# parameters. Equal torques score 100 %. On this
# recording least squares scores 95 and 94 %. Algorithm 1 keeps a corrected guess only
# if no parameter is negative (line 22). Of the guesses with seeds 0 to 399, which go up to 1 only, eight pass.


# %%
def torque_of(parameters: np.ndarray) -> np.ndarray:
    """Torque in N m of parameters in units of the largest torque."""
    return scale * repro.inverse_dynamics(q, dq, ddq, parameters)


scores = {}
for name, parameters in {"guess": guess, "corrected": corrected}.items():
    scores[name] = 100 * repro.similarity(tau, torque_of(parameters)).total
    print(f"{name:10}", scores[name].round(1))

# %% [markdown]
# The figure shows the two channels of the image (top), the parameters and the torque of joint 1 (bottom):

# %%
figure, grid = plt.subplots(2, 2, figsize=(7.2, 6.4), layout="constrained")
axes = grid.ravel()
for axis, channel, title in zip(axes, image, ("image, channel 1", "image, channel 2"), strict=False):
    axis.imshow(channel, cmap="viridis")
    axis.set(title=title, xlabel="sample of the torque", ylabel="sample of the guess")
x = np.arange(9)
axes[2].bar(x - 0.3, guess, 0.3, label="guess")
axes[2].bar(x, residual, 0.3, label="residual")
axes[2].bar(x + 0.3, corrected, 0.3, label="corrected")
axes[2].set(title="parameters / largest torque", xticks=x, xticklabels=NAMES)
axes[2].legend(fontsize=8)
for values, label, style in (
    (tau, "measured", "k-"),
    (torque_of(guess), "guess", "C0:"),
    (torque_of(corrected), "corrected", "C2--"),
):
    axes[3].plot(run.t[capture.n1 + samples], values[0], style, label=label)
axes[3].set(
    title=f"joint 1: {scores['guess'][0]:.0f} %, corrected {scores['corrected'][0]:.0f} %",
    xlabel="time, s",
    ylabel="torque, N m",
)
axes[3].legend(fontsize=8)
figure  # noqa: B018

# %% [markdown]
# ## Many guesses
#
# Algorithm 1 guesses each parameter between 0.001 and 3. The first row of the output uses 1,000 such guesses. In the
# other rows the true parameters of the simulated arm are the only guess. The last row takes the torque from Eq. 1, not
# from the recording. An error is the root mean square over the nine parameters, in units of the largest torque.
# *Possible* estimates pass line 22.

# %%
beta = np.array(yaml.safe_load((DATA.parent / "config/config.yaml").read_text())["arm"]["parameters"])
exact = repro.inverse_dynamics(q, dq, ddq, beta)
random = np.random.default_rng(4).uniform(0.001, 3.0, (1000, 9))
for name, torque, given in (("random", tau, random), ("true", tau, None), ("true, Eq. 1", exact, None)):
    true = beta / abs(torque).max()
    guesses = true[np.newaxis] if given is None else given
    estimates = guesses + repro.estimate_residuals(network, repro.images(q, dq, ddq, torque, guesses))
    before, after = (np.median(np.sqrt(np.mean((x - true) ** 2, axis=1))) for x in (guesses, estimates))
    possible = 100 * np.mean((estimates >= 0).all(axis=1))
    print(f"{name:12} error of guess {before:.2f}, of estimate {after:.2f}; possible: {possible:.0f} %")

# %% [markdown]
# The network brings random guesses much nearer to the true parameters, but not close. Most of these estimates have a
# negative parameter, so line 22 rejects them. The network moves even the true parameters away, by 0.13. With the torque
# of Eq. 1, without the other effects of the arm, it moves them by 0.07. Line 22 rejects both estimates, too. Good
# estimates are therefore rare, and Algorithm 1 must draw many guesses.
