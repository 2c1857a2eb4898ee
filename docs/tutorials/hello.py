# %% [markdown]
# # Hello, arm
#
# This page needs only the package (`python -m pip install .` in the project's folder). It simulates a log of a known
# arm, identifies the arm, and predicts a torque. Open `docs/tutorials/hello.py` as a notebook in Jupyter (with
# jupytext) or in an editor that supports `# %%` cells.
#
# ## A log
#
# The [model](../../own-arm.md#the-model-eq-1) has nine parameters: inertias I1 to I3, gravity g1 and g2, viscous
# friction b1 and b2, Coulomb friction k1 and k2. `repro.excite` designs a motion within the limits of an arm.

# %%
import numpy as np

import repro

true = np.array([0.9, 0.12, 0.2, 4.0, 1.1, 0.3, 0.15, 0.5, 0.25])
arm = repro.Arm(position_limit=((-1.5, 1.5), (-2.0, 2.0)), speed_limit=(4.0, 6.0))


def record(harmonics: int, seed: int) -> repro.Log:
    """Simulate a log of the true arm, with noise of 0.05 N m and 0.1 mrad."""
    motion = repro.excite(arm, duration=16.0, rate=200.0, harmonics=harmonics, seed=seed)
    noise = np.random.default_rng(seed)
    torque = repro.inverse_dynamics(motion.q, motion.dq, motion.ddq, true) + noise.normal(0.0, 0.05, motion.q.shape)
    return repro.Log(t=motion.time, q=motion.q + noise.normal(0.0, 1e-4, motion.q.shape), tau=torque)


log = record(harmonics=6, seed=1)
print(log.q.shape, "samples of both joints in", round(log.t[-1] - log.t[0], 1), "s")

# %% [markdown]
# ## Identify
#
# `low` and `high` are the ends of the 95 % interval. The intervals are narrow, because the model is exact in this
# simulation. On real arms they are wider.

# %%
unseen = record(harmonics=4, seed=2)
result = repro.identify(log, validate=unseen)
table = result.parameters[["estimate", "low", "high", "unit"]].copy()
table.insert(0, "true", true)
print(table.round(3).to_string())

# %% [markdown]
# ## Errors and warnings
#
# The torque error is the RMS of the residual (measured minus rebuilt torque) divided by the RMS of the torque. It is
# computed here on the motion that was not fitted. Read the warnings
# ([fix a log](../../fix-a-log.md)) before you use a result.

# %%
errors = result.errors.query("part == 'validation'")
print((100 * errors["relative_rms"]).round(1).to_list(), "% of joints 1 and 2")
print(*result.warnings or ["no warnings"], sep="\n")

# %% [markdown]
# On the fitted log, measured and rebuilt torque of both joints coincide. The residual (below) is smaller than the
# noise, because `identify` filters the log first:

# %%
result.plot()

# %% [markdown]
# ## Predict
#
# The code predicts the torque that holds the arm still with link 1 level and link 2 in line with it. The true torque is
# g1 + g2 at joint 1 and g2 at joint 2.

# %%
still = np.zeros((2, 1))
level = np.array([[np.pi / 2], [0.0]])
print("predicted", result.predict(level, still, still)[:, 0].round(2), "true", np.array([true[3] + true[4], true[4]]))

# %% [markdown]
# Next: [your own arm](../../own-arm.md), [a real arm](real-arm.md).
