"""What a capture is used for: evenly spaced samples, a check by the control law, a table."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from repro.errors import InputError
from repro.fpga.capture import Capture
from repro.fpga.controller import PDController
from repro.model.parameters import Array


@dataclass(frozen=True)
class Samples:
    """One sample for every sampling instant of a motion."""

    q: Array  # (2, N), joint positions, rad
    tau: Array  # (2, N), joint torques, N m
    filled: int  # samples that were lost and are interpolated


def samples(capture: Capture, longest_gap: int = 4) -> Samples:
    """Evenly spaced samples; short gaps are bridged by straight lines."""
    n, good = capture.about.samples, len(capture.index)
    if not capture.complete:
        raise InputError.at(capture.place, f"an incomplete recording ({capture.reason})", "a complete one")
    for gap in capture.gaps:
        where = f"{capture.place}: byte {gap.offset}"
        if gap.lost > longest_gap:
            raise InputError.at(where, f"a gap of about {gap.lost} samples", f"at most {longest_gap}")
        if gap.lost and gap.next_frame in (0, good):
            raise InputError.at(where, f"a gap of about {gap.lost} samples", "gaps between samples only")
    if good + capture.counts.lost != n:
        found = f"{good} and about {capture.counts.lost} lost"
        raise InputError.at(f"{capture.place}: samples", found, f"{n} together")
    instants = np.arange(n)
    q, tau = (
        np.stack([np.interp(instants, capture.index, joint) for joint in rows]) for rows in (capture.q, capture.tau)
    )
    return Samples(q, tau, n - good)


@dataclass(frozen=True)
class ControlCheck:
    """How many frames the control law confirms."""

    checked: int  # frames whose torque can be recomputed: not those right after a gap
    # Those of them, by their place among the frames, whose torque is not what the law gives
    disagree: NDArray[np.int64]

    @property
    def agree(self) -> int:
        """Frames confirmed."""
        return self.checked - self.disagree.size


def verify_control(capture: Capture) -> ControlCheck:
    """Recompute the torque of each frame from the positions, bit by bit as the board does (Eq. 2).

    The protocol has no checksum, but the torque follows from this position, the one before and the desired one. So
    a flipped bit that the parser cannot see is found here, in its own frame or in the one after it.

    Parameters
    ----------
    capture : Capture
        Recording.

    Returns
    -------
    ControlCheck
        Frames checked and those that disagree.
    """
    q_d = capture.about.desired
    index = capture.index
    before = np.concatenate([[-1], index[:-1]])
    checked = np.flatnonzero((index - before == 1) & (index < q_d.shape[1]))
    control = PDController(capture.about.control.kp_counts, capture.about.control.kv_counts)
    # Every frame as an arm of its own: one call with the position before, one with the position.
    position = capture.position.astype(np.int32)
    control(q_d[:, index[checked]], position[:, np.maximum(checked - 1, 0)])
    pwm = control(q_d[:, index[checked]], position[:, checked])
    return ControlCheck(checked.size, checked[(pwm != capture.pwm[:, checked]).any(axis=0)])


def to_table(capture: Capture) -> pd.DataFrame:
    """Frames that arrived, one a row."""
    gap = np.zeros(len(capture.index) + 1, dtype=np.int64)
    gap[[each.next_frame for each in capture.gaps if each.lost]] = 1
    columns: dict[str, NDArray[np.generic]] = {"time_s": capture.time}
    for names, rows in (
        (("q1_rad", "q2_rad"), capture.q),
        (("tau1_Nm", "tau2_Nm"), capture.tau),
        (("q1_counts", "q2_counts"), capture.position),
        (("pwm1", "pwm2"), capture.pwm),
    ):
        columns |= dict(zip(names, rows, strict=True))
    return pd.DataFrame(columns | {"gap": gap[:-1], "simulated": int(capture.about.source == "simulated")})
