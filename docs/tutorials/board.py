# %% [markdown]
# # The board, from motion to parameters (simulated)
#
# The board, the arm behind it and all numbers on this page are **simulated**. A board of your own that speaks [the
# protocol](../../protocol.md) is used the same way, with another port, such as `/dev/ttyUSB0`.
#
# ## Record
#
# `repro simulate` starts a simulated board behind a serial port, here the link `board`. Without `--as-fast-as-possible`
# the board keeps the pace of a real one, 2.5 ms per sample.

# %%
import atexit
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

import repro


def command(*arguments: str) -> None:
    """Run a subcommand of repro and print its answer."""
    run = subprocess.run([sys.executable, "-m", "repro", *arguments], check=True, capture_output=True, text=True)
    print(run.stdout)


board = subprocess.Popen([sys.executable, "-m", "repro", "simulate", "--link", "board", "--as-fast-as-possible"])
atexit.register(board.terminate)
while not Path("board").exists():
    time.sleep(0.1)
command("record", "--port", "./board", "--trajectory", "ID", "--out", "ID.bin")
command("record", "--port", "./board", "--trajectory", "T2", "--out", "T2.bin")

# %% [markdown]
# ID is the trajectory of Eq. 10. T2 is a validation motion of Section VI.
#
# ## Identify
#
# The simulated arm has known parameters.

# %%
simulated = repro.read_capture("ID.bin").metadata.board["arm"]
true = np.array(simulated["parameters"])
true[5:7] += simulated["further_viscous_nm_s_per_rad"]  # back-EMF, zero for this arm


def show(result: repro.Identification) -> None:
    """Print estimates with their intervals next to the true parameters."""
    table = result.parameters[["estimate", "low", "high", "verdict"]].copy()
    table.insert(0, "true", true)
    print(table.round(3).to_string())


slow = repro.identify("ID.bin", validate="T2.bin", method="ordinary")
show(slow)

# %% [markdown]
# Eq. 10 is slow (10.8 s here, without lead-in and margins). It excites gravity and friction, but hardly inertia, so the
# interval of I2 contains zero. The arm has [Stribeck friction](../../glossary.md), which Eq. 1 does not model. The tool
# finds and subtracts this friction at joint 1. All intervals except that of k2 contain the true value. The friction of
# joint 2 grows with the torque of its drive, so k2 is 77 % too high. Its verdict is still *known to 28 %*, because the
# intervals allow only for friction that grows with the load behind the gear.
#
# ## What to excite
#
# | parameters | motion |
# |---|---|
# | gravity (g1, g2) | a large range, best beyond 90 degrees on both sides (here the limit is 86) |
# | friction (b, k) | slow *and* fast motion in the same log, each in both directions |
# | inertia (I1, I3) | acceleration up to what the drives can do, also of each joint while the other is slow |
# | coupling (I2) | both joints fast at once, q2 well beyond 90 degrees, where the coupling changes sign (not here) |
#
# Record many oscillations, with different frequencies at the two joints. `repro.excite` designs such a motion
# within the limits of an arm. `repro record` refuses a motion beyond the limits of the board before it sends anything
# ([recording](../../recording.md)).

# %%
arm = repro.Arm(position_limit=((-1.5, 1.5), (-1.5, 1.5)), speed_limit=(4.0, 6.0))
motion = repro.excite(arm, duration=20.0, rate=400.0, harmonics=10)
np.savetxt("motion.csv", motion.q.T[:8001], delimiter=",", header="q1_rad,q2_rad", comments="", fmt="%.6f")
command("record", "--port", "./board", "--trajectory", "motion.csv", "--out", "motion.bin")
fast = repro.identify("motion.bin", validate="T2.bin", method="ordinary")
show(fast)

# %% [markdown]
# I1, I3, g1 and g2 are now within 12 % of the true values. All intervals except that of k1 contain the true value. The
# estimate of k1 includes Stribeck friction, as its verdict states. The residual (lower curves) shows the ripple:

# %%
fast.plot(log=0)

# %% [markdown]
# ## What a better log does not do
#
# The parameters are nearer to the truth than with ID. The torque errors on T2 are only a little smaller, because T2 has
# friction and ripple that neither fit fully contains:

# %%
for name, result in {"ID": slow, "excited": fast}.items():
    errors = result.errors.query("part == 'validation'")
    print(f"{name}: {(100 * errors['relative_rms']).round(1).tolist()} % of joints 1 and 2")

# %% [markdown]
# To learn the parameters, excite all nine. To predict similar motions, the slow log is nearly as good as the excited
# one.
