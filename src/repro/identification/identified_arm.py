"""The arm that was identified: Eq. 1 with the terms beyond it, and how a log records its angles and torques."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from repro.identification.calibration import CALIBRATION
from repro.identification.extra_terms import (
    LOAD,
    N_LOAD,
    ROTOR,
    TERM_NAMES,
    TERMS,
    ExtraTerm,
    SmoothLog,
    raw_columns,
    values_of,
)
from repro.identification.filtering import FilterSettings
from repro.identification.scores import integrate
from repro.model.dynamics import check_motion, mass_matrix, regressor
from repro.model.parameters import Array

MAX_LOAD_ITERATIONS = 5  # solutions after which the directions of the loads, two of each, must be right


@dataclass(frozen=True, eq=False)
class IdentifiedArm:
    """Parameters of Eq. 1 with what was subtracted or corrected before they were estimated."""

    beta: Array  # (9,)
    friction_steepness: float  # lambda, s/rad
    terms: Sequence[ExtraTerm] = ()  # beyond Eq. 1
    load: Array | None = None  # parameters (9,) that give the load of friction; those of the arm without
    calibration: Mapping[str, float] = field(default_factory=dict)  # errors of the log that records, by name
    stribeck_speed: float | None = None  # at which Stribeck friction has fallen to 1/e, rad/s

    def torque(self, q: ArrayLike, dq: ArrayLike, ddq: ArrayLike) -> Array:
        """Compute the torque (..., 2, N) that the log would record along a motion as it records it."""
        recorded, dq, ddq = check_motion(q, dq, ddq)
        zero, offset, scale = (
            np.array([[self.calibration.get(f"{name}{j}", kind.neutral)] for j in (1, 2)])
            for name, kind in CALIBRATION.items()
        )
        settings = FilterSettings(friction_steepness=self.friction_steepness)
        if self.stribeck_speed is not None:
            settings = replace(settings, stribeck_speed=self.stribeck_speed)
        load = self.beta if self.load is None else self.load
        along = SmoothLog((recorded + zero, dq, ddq), np.zeros_like(dq), load, np.nan, settings)
        torque = along.y @ self.beta
        if self.terms:
            subset, values = [TERM_NAMES.index(term.name) for term in self.terms], [term.value for term in self.terms]
            torque = torque + raw_columns(TERMS, along)[..., subset] @ np.array(values)
        return np.asarray(torque * scale + offset)

    def simulate(self, t: ArrayLike, tau: ArrayLike, q0: ArrayLike, dq0: ArrayLike) -> tuple[Array, Array]:
        """Integrate the motion (2, N) from a state (2,) under a torque (2, N) that is linear between instants."""
        accelerate = self._acceleration if self.terms else None
        return integrate(t, tau, q0, dq0, self.beta, self.friction_steepness, accelerate)

    def _acceleration(self, q: Array, dq: Array, tau: Array) -> Array:
        """Solve `torque` for the acceleration (2,): it is linear in it where the direction of each load is known."""
        values = values_of(self.terms)
        load_beta = self.beta if self.load is None else self.load
        at_rest = replace(self, calibration={}, terms=[t for t in self.terms if t.kind != LOAD])
        rest = tau - at_rest.torque(q[:, None], dq[:, None], np.zeros((2, 1)))[:, 0]
        mass = mass_matrix(q, self.beta) + np.diag([values.get(f"{ROTOR}{joint}", 0.0) for joint in (1, 2)])
        load_mass = mass_matrix(q, load_beta)
        still = regressor(q[:, None], dq[:, None], np.zeros((2, 1)))[:, 0, :N_LOAD] @ load_beta[:N_LOAD]
        friction = np.array([values.get(f"{LOAD}{joint}", 0.0) for joint in (1, 2)])
        friction *= np.tanh(self.friction_steepness * dq)
        ddq = np.linalg.solve(mass, rest)
        for _ in range(MAX_LOAD_ITERATIONS):
            factor = friction * np.sign(load_mass @ ddq + still)
            before, ddq = ddq, np.linalg.solve(mass + factor[:, None] * load_mass, rest - factor * still)
            if np.array_equal(before, ddq):
                break
        return np.asarray(ddq, dtype=np.float64)
