"""Captures in use: the recording at even instants, a check by the control law, a table."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from repro.errors import InputError
from repro.fpga.capture import Capture
from repro.fpga.controller import PDController
from repro.model.parameters import Array

#: Most samples in a row that are interpolated.
LONGEST_GAP = 4


@dataclass(frozen=True)
class Recording:
    """Positions and torques of a motion, one sample for every sampling instant."""

    q: Array  # (2, N), joint positions, rad
    tau: Array  # (2, N), joint torques, N m
    n_interpolated: int  # samples that were lost


def recording_of(capture: Capture) -> Recording:
    """Resample a complete capture to even instants; gaps of few samples are interpolated linearly."""
    n, good = capture.metadata.samples, len(capture.index)
    if not capture.complete:
        raise InputError.at(capture.place, f"an incomplete recording ({capture.metadata.end_reason})", "a complete one")
    for gap in capture.gaps:
        where = f"{capture.place}: byte {gap.offset}"
        if gap.lost > LONGEST_GAP:
            raise InputError.at(where, f"a gap of about {gap.lost} samples", f"at most {LONGEST_GAP}")
        if gap.lost and gap.next_frame in (0, good):
            raise InputError.at(where, f"a gap of about {gap.lost} samples", "gaps between samples only")
    if good + capture.counts.lost != n:
        found = f"{good} and about {capture.counts.lost} lost"
        raise InputError.at(f"{capture.place}: samples", found, f"{n} together")
    instants = np.arange(n)
    q, tau = (
        np.stack([np.interp(instants, capture.index, joint) for joint in rows]) for rows in (capture.q, capture.tau)
    )
    return Recording(q, tau, n - good)


@dataclass(frozen=True)
class ControlCheck:
    """Number of frames that the control law confirms."""

    checked: int  # frames whose torque can be recomputed: not those right after a gap
    disagree: NDArray[np.int64]  # indices of those whose torque is another

    @property
    def agree(self) -> int:
        """Frames confirmed."""
        return self.checked - self.disagree.size


def verify_control(capture: Capture) -> ControlCheck:
    """Recompute the torque of each frame from the positions, bit by bit as the board does (Eq. 2).

    The protocol has no checksum, but the torque follows from this position, the one before and the desired one. So
    a flipped bit that the parser cannot see is found here, in its own frame or in the one after it.
    """
    q_d = capture.metadata.desired
    index = capture.index
    before = np.concatenate([[-1], index[:-1]])
    checked = np.flatnonzero((index - before == 1) & (index < q_d.shape[1]))
    control = PDController(capture.metadata.control.kp_counts, capture.metadata.control.kv_counts)
    # Every frame as an arm of its own: one call with the position before, one with the position.
    position = capture.position.astype(np.int32)
    control(q_d[:, index[checked]], position[:, np.maximum(checked - 1, 0)])
    pwm = control(q_d[:, index[checked]], position[:, checked])
    return ControlCheck(checked.size, checked[(pwm != capture.pwm[:, checked]).any(axis=0)])


def to_table(capture: Capture) -> pd.DataFrame:
    """Tabulate the frames that arrived; `gap` is 1 where samples are missing before the frame."""
    gaps = np.zeros(len(capture.index) + 1, dtype=np.int64)
    gaps[[gap.next_frame for gap in capture.gaps if gap.lost]] = 1
    columns: dict[str, NDArray[np.generic]] = {"time_s": capture.time}
    for names, rows in (
        (("q1_rad", "q2_rad"), capture.q),
        (("tau1_Nm", "tau2_Nm"), capture.tau),
        (("q1_counts", "q2_counts"), capture.position),
        (("pwm1", "pwm2"), capture.pwm),
    ):
        columns |= dict(zip(names, rows, strict=True))
    return pd.DataFrame(columns | {"gap": gaps[:-1], "simulated": int(capture.metadata.source == "simulated")})
