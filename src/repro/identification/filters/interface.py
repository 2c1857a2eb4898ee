"""Zero-phase low-pass filters that differentiate: one interface, one file each.

A filter is told its half-power frequency, so the three can be exchanged without choosing anew.
"""

from collections.abc import Callable
from dataclasses import dataclass

from repro.identification.filters.butterworth import butterworth
from repro.identification.filters.dct_pair import dct_pair
from repro.identification.filters.savitzky_golay import savitzky_golay
from repro.model.parameters import Array


@dataclass(frozen=True)
class Filter:
    """A zero-phase low-pass filter.

    Attributes
    ----------
    name : str
        In words.
    apply : callable
        ``apply(x, h, cutoff, order)``: the `order`-th time derivative (0, 1 or 2) of the low-passed `x` of shape
        (..., N), with `h` in s and `cutoff`, the half-power frequency, in Hz. ValueError
        for another order.
    """

    name: str
    apply: Callable[[Array, float, float, int], Array]


FILTERS: dict[str, Filter] = {
    "dct": Filter("Gaussian on the DCT-II bands (Eq. 6), derivatives by the matching sine series", dct_pair),
    "savitzky-golay": Filter("Savitzky-Golay, cubic", savitzky_golay),
    "butterworth": Filter("Butterworth of order 4 run forwards and backwards, central differences", butterworth),
}
