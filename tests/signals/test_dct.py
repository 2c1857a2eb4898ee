"""DCT-II spectrum, low-pass, derivative and subsampling (Eq. 5-7, 14; Fig. 5)."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from literal import cosines
from strategies import seeds

from repro.signals.dct import FREQUENCY_UNITS, dct2dev, dct2low, dct2sub, spectrum

H = 2.5e-3


@given(seed=seeds, n=st.integers(1, 60))
def test_spectrum_is_eq5(seed, n):
    x = np.random.default_rng(seed).normal(size=n)
    np.testing.assert_allclose(spectrum(x), cosines(n) @ x, rtol=0, atol=1e-12)


@given(seed=seeds, sizes=st.tuples(st.integers(2, 300), st.integers(1, 300)).map(sorted))
def test_dct2sub_resamples_a_band_limited_signal_exactly(seed, sizes):
    # N is hardly ever a multiple of M here. Any sum of the first M cosines is the same curve seen at M points.
    m, n = sizes
    amplitude = np.random.default_rng(seed).normal(size=m)
    turns = (np.pi * np.outer(np.arange(m), np.arange(0.5, size)) / size for size in (n, m))
    curve_n, curve_m = (amplitude @ np.cos(turn) for turn in turns)
    np.testing.assert_allclose(dct2sub(curve_n, m), curve_m, rtol=0, atol=1e-9)


OMEGA = {
    "rad_per_s": lambda k, n, h: np.pi * k / (n * h),
    "hertz": lambda k, n, h: k / (2.0 * n * h),
    "index": lambda k, n, h: float(k),
}


@pytest.mark.parametrize("unit", FREQUENCY_UNITS)
@given(seed=seeds, n=st.integers(2, 40), h=st.floats(1e-3, 1.0), depth=st.floats(0.0, 5.0))
def test_dct2dev_is_eq6_and_dct2low_eq14_step_by_step(unit, seed, n, h, depth):
    x = np.random.default_rng(seed).normal(size=n)
    c_f = depth / OMEGA[unit](n // 2, n, h) ** 2  # the middle of the bands is reduced to exp(-depth)
    slope = np.array([(x[max(i, 1)] - x[max(i, 1) - 1]) / h for i in range(n)])
    gains = np.array([np.exp(-c_f * OMEGA[unit](k, n, h) ** 2) for k in range(n)])
    for found, signal in ((dct2low(x, h, c_f, unit), x), (dct2dev(x, h, c_f, unit), slope)):
        expected = cosines(n).T @ (gains * (cosines(n) @ signal))
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * np.abs(signal).max())


ROW = np.arange(6.0)
BROKEN = np.array([1.0, np.nan, 3.0])


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: spectrum(np.float64(1.0)), r"^x: .*at least one sample"),
        (lambda: spectrum(np.empty((2, 0))), r"^x: .*at least one sample"),
        (lambda: spectrum(BROKEN), r"^x: every sample must be finite"),
        (lambda: dct2low(BROKEN, H, 1e-4), r"^x: every sample must be finite"),
        (lambda: dct2low(ROW, 0.0, 1e-4), r"^h: "),
        (lambda: dct2low(ROW, np.nan, 1e-4), r"^h: "),
        (lambda: dct2low(ROW, H, -1e-4), r"^c_f: "),
        (lambda: dct2low(ROW, H, np.inf), r"^c_f: "),
        (lambda: dct2low(ROW, H, 1e-4, "Hz"), r"^unit: .*'Hz'"),
        (lambda: dct2dev(np.ones(1), H, 0.0), r"^x: .*at least two samples"),
        (lambda: dct2dev(BROKEN, H, 0.0), r"^x: every sample must be finite"),
        (lambda: dct2sub(ROW, 0), r"^m: must be between 1 and the 6 samples of x, got 0"),
        (lambda: dct2sub(ROW, 7), r"^m: must be between 1 and the 6 samples of x, got 7"),
    ],
)
def test_broken_arguments_are_named(call, message):
    with pytest.raises(ValueError, match=message):
        call()
