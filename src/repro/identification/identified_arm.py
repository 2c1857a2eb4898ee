"""The arm that was identified: Eq. 1 with the terms beyond it, and how a log records its angles and torques."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from repro.identification.calibration import CALIBRATION
from repro.identification.extra_terms import TERM_NAMES, TERMS, ExtraTerm, SmoothLog, raw_columns
from repro.identification.filtering import FilterSettings
from repro.model.dynamics import check_motion
from repro.model.parameters import Array


@dataclass(frozen=True, eq=False)
class IdentifiedArm:
    """Parameters of Eq. 1 with what was subtracted or corrected before they were estimated."""

    beta: Array  # (9,)
    friction_steepness: float  # lambda, s/rad
    terms: Sequence[ExtraTerm] = ()  # beyond Eq. 1
    load: Array | None = None  # parameters (9,) that give the load of friction; those of the arm without
    calibration: Mapping[str, float] = field(default_factory=dict)  # errors of the log that records, by name

    def torque(self, q: ArrayLike, dq: ArrayLike, ddq: ArrayLike) -> Array:
        """Compute the torque (..., 2, N) that the log would record along a motion as it records it."""
        recorded, dq, ddq = check_motion(q, dq, ddq)
        zero, offset, scale = (
            np.array([[self.calibration.get(f"{name}{j}", kind.neutral)] for j in (1, 2)])
            for name, kind in CALIBRATION.items()
        )
        settings = FilterSettings(friction_steepness=self.friction_steepness)
        load = self.beta if self.load is None else self.load
        along = SmoothLog((recorded + zero, dq, ddq), np.zeros_like(dq), load, np.nan, settings)
        torque = along.y @ self.beta
        if self.terms:
            subset, values = [TERM_NAMES.index(term.name) for term in self.terms], [term.value for term in self.terms]
            torque = torque + raw_columns(TERMS, along)[..., subset] @ np.array(values)
        return np.asarray(torque * scale + offset)
