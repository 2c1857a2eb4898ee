"""Strategies and cuts that several tests share."""

from itertools import accumulate, pairwise

import numpy as np
from hypothesis import strategies as st

from repro.model.parameters import Links

seeds = st.integers(min_value=0, max_value=2**32 - 1)


def cut(data, sizes):
    """Pieces of these sizes one after the other, and the rest."""
    return [data[begin:end] for begin, end in pairwise([0, *accumulate(sizes), len(data)])]


def links():
    """Two links with masses, lengths and inertias well above zero, centre of mass anywhere on a link or beyond."""
    mass, length, inertia = st.floats(0.05, 5.0), st.floats(0.05, 1.0), st.floats(0.01, 0.5)
    return st.builds(Links, m1=mass, m2=mass, l1=length, lc1=length, lc2=length, j1=inertia, j2=inertia)


@st.composite
def feasible_betas(draw):
    """Parameter sets whose inertia matrix is positive definite with some margin, friction not negative."""
    i3, excess = draw(st.floats(0.1, 1.0)), draw(st.floats(0.1, 1.0))
    coupling = draw(st.floats(-0.9, 0.9))
    rest = [draw(st.floats(0.0, 1.0)) for _ in range(6)]
    return np.array([i3 + excess, 2.0 * coupling * np.sqrt(i3 * excess), i3, *rest])
