"""Least squares with every parameter zero or more: what line 22 of Algorithm 1 asks of a candidate."""

import numpy as np
from scipy.optimize import lsq_linear

from repro.identification.methods.interface import Estimate, Method
from repro.identification.solve import asked, nine_rows, snap
from repro.model.parameters import NAMES, Array


def solve(y: Array, tau: Array) -> Estimate:
    """Least squares under the bounds beta >= 0, with the names of the parameters held there."""
    r, c, scale = nine_rows(y, tau)
    z = lsq_linear(r, c, bounds=(0.0, np.inf), method="bvls").x * asked(r, c)
    beta = snap(np.maximum(z, 0.0), 1e-12) / scale
    held = [name for name, value in zip(NAMES, beta, strict=True) if value == 0.0]
    return Estimate(beta, (f"held at zero: {', '.join(held)}",) if held else ())


METHOD = Method("bounded", "bounded least squares", "branch1999subspace", lambda r: solve(r.y, r.tau))
