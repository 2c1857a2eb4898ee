"""What the paper leaves open of the experiment: ranges of the unknowns, and hypotheses that are tried with each other.

Fixed before the search was run (git history); `docs/explanation/experiment.md` has the outcome.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from typing import Any, Literal

import numpy as np

from repro.model.parameters import NAMES, Array
from repro.paper.appendix import FreeChoices, appendix_arm
from repro.paper.published import Published
from repro.signals.dct import FrequencyUnit

#: Ranges of the unknowns. The arm is a member of the family that gives every number of Appendix A.
RANGES: dict[str, tuple[float, float]] = {
    "i1": (0.10, 0.30),  # kg m^2
    "l1": (0.12, 0.20),  # m
    "g1": (0.40, 1.60),  # N m
    "k1": (0.20, 0.50),  # N m
    "k2_share": (0.10, 0.70),  # k2 over k1: the appendix takes joint 1 to have the larger friction
    "viscous1": (0.0, 0.30),  # N m s/rad
    "viscous2": (0.0, 0.30),
    "stribeck1": (0.0, 2.0),
    "stribeck2": (0.0, 2.0),
    "stribeck_velocity": (0.05, 0.50),  # rad/s
    "ripple1": (0.0, 0.20),  # N m
    "ripple2": (0.0, 0.10),
    "ripple_cycles": (5.0, 25.0),
    "load_friction1": (0.0, 0.40),
    "load_friction2": (0.0, 0.40),
    "duration_s": (3.0 * np.pi, 19.5),  # of ID; the memory of 8192 samples has its lead-in, too
    "t1_samples": (2500.0, 8192.0),
    "t1_bands": (5.0, 100.0),  # 100 is the printed c_f
    "t2_samples": (2500.0, 8192.0),
    "t2_turns": (1.0, 10.0),
    "t2_centre": (0.40, 0.85),
    "t3_samples": (2500.0, 8192.0),
    "t3_levels": (0.30, 1.0),
    "t4_samples": (2500.0, 8192.0),
    "t4_amplitude1": (0.04, 1.2),  # rad
    "t4_amplitude2": (0.04, 1.2),
    "t4_frequency1": (0.08, 0.60),  # Hz
    "t4_frequency2": (0.08, 0.60),
}
#: Unknowns whose logarithm is searched: the print bounds the size of these motions from above.
LOGARITHMIC = ("t1_bands", "t4_amplitude1", "t4_amplitude2")
VISCOUS = ("viscous1", "viscous2")
#: Unknowns that are whole numbers.
INTEGERS = ("t1_samples", "t2_samples", "t3_samples", "t4_samples")

TrackingOrder = Literal["printed", "swapped"]


@dataclass(frozen=True)
class Hypothesis:
    """One choice of each question that has two answers."""

    unit: FrequencyUnit  # of omega in the filter of Algorithm 1
    back_emf_in_b: bool  # whether the b of the appendix has the back-EMF, so that there is no further viscous friction
    tracking: TrackingOrder  # order of the joints in which Table 8 prints the similarity of its tracking

    @property
    def unknowns(self) -> list[str]:
        """Names of what is searched."""
        return [name for name in RANGES if not (self.back_emf_in_b and name in VISCOUS)]

    def values(self, place: Array, drawn: Mapping[str, float], published: Published) -> dict[str, Any]:
        """Return the columns of an experiment at a place of the unit cube; ValueError if the family has no such arm.

        `drawn` has what a start draws and does not search: the phases of the ripple and the seed of T1.
        """
        x: dict[str, Any] = {"unit": self.unit, **dict.fromkeys(VISCOUS, 0.0), **drawn}
        for name, share in zip(self.unknowns, place, strict=True):
            low, high = RANGES[name]
            value = low * (high / low) ** share if name in LOGARITHMIC else low + share * (high - low)
            x[name] = round(value) if name in INTEGERS else float(f"{value:.6g}")
        i1, g1, k1, k2_share = (x.pop(name) for name in ("i1", "g1", "k1", "k2_share"))
        beta = appendix_arm(FreeChoices(i1, x["l1"], g1, k1, k2_share * k1), published)
        return dict(zip(NAMES, (float(f"{b:.8g}") for b in beta), strict=True)) | x


UNITS: tuple[FrequencyUnit, ...] = ("index", "rad_per_s")
ORDERS: tuple[TrackingOrder, ...] = ("printed", "swapped")
HYPOTHESES = [Hypothesis(*choices) for choices in product(UNITS, (False, True), ORDERS)]
