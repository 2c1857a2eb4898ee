"""Zero-phase filters and their derivatives against sines, polynomials and the cosine series written out."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from strategies import seeds

from repro.identification.filtering import FILTERS, dct_pair, filter_coefficient
from repro.signals.dct import dct2low

H = 1.0 / 200.0
T = H * np.arange(4000)
#: Away from the edges.
MIDDLE = slice(1000, 3000)

every_filter = pytest.mark.parametrize("name", sorted(FILTERS))


def response(name, frequency, cutoff, h=H, order=0):
    """Gain of a filter at a frequency, complex, by least squares in the middle of a long sine."""
    t = h * np.arange(round(20.0 / h))
    middle = slice(t.size // 4, 3 * t.size // 4)
    turn = 2 * np.pi * frequency * t
    filtered = FILTERS[name].apply(np.sin(turn), h, cutoff, order)
    waves = np.stack([np.sin(turn), np.cos(turn)], axis=-1)
    (sine, cosine), *_ = np.linalg.lstsq(waves[middle], filtered[middle])
    return sine + 1j * cosine


@every_filter
@pytest.mark.parametrize(("rate", "cutoff"), [(100, 2.0), (100, 5.0), (200, 1.0), (200, 5.0), (200, 10.0), (1000, 5.0)])
def test_power_is_halved_at_the_stated_frequency(name, rate, cutoff):
    assert abs(response(name, cutoff, cutoff, 1.0 / rate)) == pytest.approx(np.sqrt(0.5), rel=0.03)


@every_filter
@pytest.mark.parametrize("frequency", [0.4, 2.0, 5.0])
def test_a_sine_is_not_delayed(name, frequency):
    assert abs(np.angle(response(name, frequency, 5.0))) < 1e-9


@every_filter
@settings(max_examples=20)
@given(seeds)
def test_derivatives_of_slow_sines_are_the_analytic_ones(name, seed):
    rng = np.random.default_rng(seed)
    omega = 2 * np.pi * rng.uniform(0.05, 0.5, (2, 4, 1))
    amplitude, phase = rng.normal(size=(2, 4, 1)), omega * T + rng.uniform(0, 2 * np.pi, (2, 4, 1))
    exact = (
        (amplitude * np.sin(phase)).sum(1),
        (amplitude * omega * np.cos(phase)).sum(1),
        (-amplitude * omega**2 * np.sin(phase)).sum(1),
    )
    for order, expected in enumerate(exact):
        found = FILTERS[name].apply(exact[0], H, 15.0, order)
        assert found.shape == exact[0].shape
        error = np.abs(found - expected)[:, MIDDLE]
        assert error.max() < 2e-3 * np.abs(expected).max()


@every_filter
@settings(max_examples=20)
@given(seeds, st.floats(-5.0, 5.0), st.sampled_from([0, 1, 2]))
def test_filters_are_linear(name, seed, factor, order):
    x, other = np.random.default_rng(seed).normal(size=(2, 3, 300))
    apply = FILTERS[name].apply
    together, apart = apply(x + factor * other, H, 5.0, order), apply(x, H, 5.0, order)
    expected = apart + factor * apply(other, H, 5.0, order)
    np.testing.assert_allclose(together, expected, rtol=0, atol=1e-9 * np.abs(expected).max())


@given(seeds, st.integers(2, 200), st.floats(0.5, 20.0))
def test_the_pair_s_low_pass_is_the_paper_s(seed, n, cutoff):
    x = np.random.default_rng(seed).normal(size=(2, n))
    np.testing.assert_allclose(dct_pair(x, H, cutoff), dct2low(x, H, filter_coefficient(cutoff)), rtol=0, atol=1e-12)


def cosine_series(x, h, cutoff):
    """The filtered signal as a function of any time, real or complex, one term after the other."""
    n = x.size
    i = np.arange(n)
    bands = np.array([np.sum(x * np.cos(np.pi * k * (2 * i + 1) / (2 * n))) * (2 - (k == 0)) / n for k in range(n)])
    omega = np.pi * np.arange(n) / (n * h)
    # Half power at the cut-off: exp(-c omega^2) = 2^(-1/2).
    gain = 2.0 ** (-0.5 * (omega / (2 * np.pi * cutoff)) ** 2)
    return lambda t: np.sum(gain * bands * np.cos(omega * (t[:, np.newaxis] + h / 2)), axis=-1)


@pytest.mark.parametrize(("n", "cutoff"), [(2, 30.0), (31, 3.0), (31, 30.0), (120, 3.0), (121, 50.0)])
def test_the_pair_s_derivatives_are_those_of_the_cosine_series(n, cutoff):
    x = np.random.default_rng(n).normal(size=n)
    series, t, step = cosine_series(x, H, cutoff), H * np.arange(n), 1e-4 * H
    smooth, slope, curvature = (dct_pair(x, H, cutoff, order) for order in (0, 1, 2))
    np.testing.assert_allclose(smooth, series(t + 0j).real, rtol=0, atol=1e-12)

    def derivative(at):
        # A complex step subtracts nothing and so loses no digits.
        return series(at + 1e-20j).imag / 1e-20

    def close(found, expected):
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-6 * np.abs(expected).max())

    close(slope, derivative(t))
    close(curvature, (derivative(t + step) - derivative(t - step)) / (2 * step))
    # Between the samples too, it is a derivative: differences of the series agree.
    close(slope, ((series(t + step + 0j) - series(t - step + 0j)) / (2 * step)).real)
