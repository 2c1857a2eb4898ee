# %% [markdown]
# # A real arm, from Python
#
# Least squares identifies this arm with a torque error of 4 to 10 % on the fitted log and of 7.5 to 12.3 % on two
# falls. The estimates of inertia and gravity differ by 3 to 11 % from the owners' published values.
#
# The Underactuated Robotics Lab of DFKI RIC has published logs of a two-joint arm that swings in the vertical plane:
# the double pendulum "design A.0", with links of 0.3 m and motors geared 6:1. Its angles and signs are those of
# [Eq. 1](../../own-arm.md#the-model-eq-1). The logs are in the public repository
# `dfki-ric-underactuated-lab/double_pendulum` under the BSD 3-Clause licence. This project does not contain them.
# Download three logs:
#
# ```sh
# base=https://raw.githubusercontent.com/dfki-ric-underactuated-lab/double_pendulum/1e8544e
# for id in 061157 060143 060329; do
#   curl --fail --location --create-dirs --output mine/$id.csv \
#     $base/data/experiment_records/design_A.0/20220812/sys_id/20220812-$id-PM_measured.csv
# done
# ```
#
# `snakemake --cores 1 tutorials` runs this page again with the logs in `mine/` or in the folder that the environment
# variable `REPRO_REALDATA` names. The output below comes from copies of the logs, rounded to six decimals.
#
# ## Look at the log

# %%
import os
from pathlib import Path

import numpy as np

import repro

logs = Path(os.environ.get("REPRO_REALDATA", "mine"))
log = repro.read_log(logs / "061157.csv")
print(f"{log.t[-1] - log.t[0]:.0f} s, {len(log.t)} samples")
print("position from", log.q.min(axis=1).round(2), "to", log.q.max(axis=1).round(2), "rad")
print("largest torque", abs(log.tau).max(axis=1).round(2), "N m")

# %% [markdown]
# The other two logs are 10 s long: a slow ramp for 5 s, then a fall with zero torque. They serve for validation.
#
# ## Identify

# %%
falls = [logs / "060143.csv", logs / "060329.csv"]
result = repro.identify(logs / "061157.csv", validate=falls, method=["ordinary", "consistent", "weighted-consistent"])
print(result.method)
print(result.parameters[["estimate", "low", "high", "unit"]].round(3))

# %% [markdown]
# Every parameter has a verdict in words. Only parameters that the method holds at zero have no 95 % interval. Friction
# in the gears grows with the load, which Eq. 1 does not model. The log shows this friction, so it is subtracted and
# reported:

# %%
for name, verdict in result.parameters["verdict"].items():
    print(f"{name}: {verdict}")
for term in result.details.terms:
    print(f"{term.name}: {term.value:.3f} +- {2 * term.error:.3f}, subtracted: {term.taken}")

# %% [markdown]
# Ordinary least squares returns negative b1 and b2, which are physically impossible. Their intervals contain zero. Of
# the methods with physically possible parameters, the recommended one predicts torque and position of the falls best.

# %%
print(result.of("ordinary").parameters.loc[["b1", "b2", "k1", "k2"], ["estimate", "low", "high"]].round(3))

# %% [markdown]
# ## Validate
#
# The table lists the torque error of each log and joint, as a fraction of the RMS of the torque.

# %%
print(result.errors[["log", "part", "joint", "relative_rms"]].round(3).to_string(index=False))

# %% [markdown]
# At joint 1 both falls have larger errors than the fitted log. At joint 2 only the first fall has a larger error. The
# figure shows the first fall. After the release at 5 s no torque acts, but the model predicts some torque, because a
# large acceleration multiplies small errors of the inertias.

# %%
result.plot(log=1)

# %% [markdown]
# ## Use the model
#
# `predict` computes the torque that a motion needs. At rest, with link 1 level and link 2 in line with it, the arm
# needs the sum of both gravity terms at joint 1 and g2 at joint 2:

# %%
level, still = np.array([[np.pi / 2], [0.0]]), np.zeros((2, 1))
print(result.predict(level, still, still).ravel().round(2), "N m")

# %% [markdown]
# `simulate` integrates the motion that a torque causes. Here the arm falls from this pose without torque:

# %%
t = np.linspace(0.0, 0.3, 31)
q, dq = result.simulate(t, np.zeros((2, 31)), level.ravel(), [0.0, 0.0])
print("after 0.3 s:", q[:, -1].round(2), "rad")

# %% [markdown]
# ## Compare with what the owners published
#
# The owners' model has masses, lengths, inertias about the joints and a rotor inertia. In the parameters of Eq. 1 they
# are:

# %%
m1, m2, l1, r1, r2, g = 0.5593806, 0.6043459, 0.3, 0.3, 0.1837769, 9.81
j1, j2, rotor, gear = 0.0534708, 0.0239237, 7.6593e-5, 6.0
i3 = j2 + gear**2 * rotor
owners = np.array([i3 + j1 + m2 * l1**2 + rotor, 2 * l1 * m2 * r2, i3, (m1 * r1 + m2 * l1) * g, m2 * r2 * g])
found = result.parameters.iloc[:5]
for name, ours, theirs in zip(found.index, found["estimate"], owners, strict=True):
    inside = "inside" if found.low[name] <= theirs <= found.high[name] else "outside"
    print(f"{name}: {ours:.4f}, owners {theirs:.4f}, {inside} the interval")

# %% [markdown]
# Four of five intervals contain the owners' value. The interval of g1 ends 3 % below it: the intervals do not allow for
# a wrong form of the subtracted friction. With `friction=False` the intervals are wider, and all five contain the
# values.
#
# `result.save("mine/real")` writes tables, a report for the browser, and the arm as URDF and MJCF.
