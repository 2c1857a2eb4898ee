"""Candidate error formulas for the two factors of ``metr2ev``, whose listing (Algorithm 2) is lost.

What the text keeps of the listing (Section IV-C): one line makes the similarity in time, the next subtracts
it from one; three lines make the spectra and normalise them; two lines make the similarity in frequency; the
product is "adjusted with a power of 0.4". So a factor is (1 - error)^0.4, and the error is what is sought.

A frequency candidate is spectrum kind x normalisation x distance, for example ``signed | 2-norm | 2-norm`` for
||X/||X|| - Y/||Y|| ||. The DCT-II of Eq. 5 is orthonormal, so it keeps inner products (Parseval), and this
error is sqrt(2 - 2 cos(x, y)) of the signals themselves: it holds nothing that their cosine does not, and the
time candidate ``unit vectors`` is the same number. Absolute, power and logarithmic spectra do hold more.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from repro.model.parameters import Array

Factor = Literal["time", "frequency"]
Pair = Callable[[Array, Array], Array]


@dataclass(frozen=True)
class Candidate:
    """One error formula."""

    factor: Factor  # factor of ``metr2ev`` it may explain
    name: str  # short name, unique within the factor
    formula: str  # the error, readable; x and X are the actual signal and its DCT-II spectrum, y and Y the rebuilt ones
    # maps two arrays ``(..., 2, N)`` (signals for time, spectra for frequency; joint, then sample) to errors ``(...,
    # 2)``; 0 for equal arguments
    error: Pair


def _mean(x: Array) -> Array:
    return np.asarray(np.mean(x, -1))


def _square(x: Array) -> Array:
    return np.asarray(np.einsum("...n,...n->...", x, x))


def _norm(x: Array) -> Array:
    return np.sqrt(_square(x))


def _norm1(x: Array) -> Array:
    return np.asarray(np.sum(np.abs(x), -1))


def _peak(x: Array) -> Array:
    return np.asarray(np.max(np.abs(x), -1))


def _peak_both(x: Array) -> Array:
    """Largest magnitude over both joints, as Eq. 8 normalises torque."""
    return np.asarray(np.max(np.abs(x), (-2, -1)))[..., None]


def _range(x: Array) -> Array:
    return np.asarray(np.ptp(x, -1))


def _std(x: Array) -> Array:
    return np.asarray(np.std(x, -1))


def _mse(x: Array, y: Array) -> Array:
    return np.asarray(_square(x - y) / x.shape[-1])


def _rmse(x: Array, y: Array) -> Array:
    return np.sqrt(_mse(x, y))


def _mae(x: Array, y: Array) -> Array:
    return np.asarray(_norm1(x - y) / x.shape[-1])


def _cosine(x: Array, y: Array) -> Array:
    return np.asarray(np.einsum("...n,...n->...", x, y) / (_norm(x) * _norm(y)))


def _correlation(x: Array, y: Array) -> Array:
    return _cosine(x - _mean(x)[..., None], y - _mean(y)[..., None])


def _unit(x: Array) -> Array:
    return np.asarray(x / _norm(x)[..., None])


def _zero_to_one(x: Array) -> Array:
    """The function ``normalize`` of Eq. 9: range 0 to 1."""
    return np.asarray((x - np.min(x, -1, keepdims=True)) / _range(x)[..., None])


def time_candidates() -> tuple[Candidate, ...]:
    """Error formulas on the signals."""
    rows: tuple[tuple[str, str, Pair], ...] = (
        ("mean square", "mean((x - y)^2), in the signal's unit squared", _mse),
        ("rms", "rms(x - y), in the signal's unit", _rmse),
        ("mean absolute", "mean|x - y|, in the signal's unit", _mae),
        ("maximum", "max|x - y|, in the signal's unit", lambda x, y: _peak(x - y)),
        ("mean difference", "|mean(x) - mean(y)|, in the signal's unit", lambda x, y: np.abs(_mean(x - y))),
        ("energy", "||x - y||^2 / ||x||^2", lambda x, y: _square(x - y) / _square(x)),
        ("relative 2-norm", "||x - y|| / ||x||", lambda x, y: _norm(x - y) / _norm(x)),
        ("relative 1-norm", "|x - y|_1 / |x|_1", lambda x, y: _norm1(x - y) / _norm1(x)),
        ("relative maximum", "max|x - y| / max|x|", lambda x, y: _peak(x - y) / _peak(x)),
        ("mean square by peak", "mean((x - y)^2) / max|x|^2", lambda x, y: _mse(x, y) / _peak(x) ** 2),
        ("rms by peak", "rms(x - y) / max|x|", lambda x, y: _rmse(x, y) / _peak(x)),
        ("mean absolute by peak", "mean|x - y| / max|x|", lambda x, y: _mae(x, y) / _peak(x)),
        (
            "mean square by common peak",
            "mean((x - y)^2) / peak(x1, x2)^2",
            lambda x, y: _mse(x, y) / _peak_both(x) ** 2,
        ),
        ("rms by common peak", "rms(x - y) / peak(x1, x2)", lambda x, y: _rmse(x, y) / _peak_both(x)),
        ("mean absolute by common peak", "mean|x - y| / peak(x1, x2)", lambda x, y: _mae(x, y) / _peak_both(x)),
        ("mean square by range", "mean((x - y)^2) / range(x)^2", lambda x, y: _mse(x, y) / _range(x) ** 2),
        ("rms by range", "rms(x - y) / range(x)", lambda x, y: _rmse(x, y) / _range(x)),
        ("mean absolute by range", "mean|x - y| / range(x)", lambda x, y: _mae(x, y) / _range(x)),
        ("maximum by range", "max|x - y| / range(x)", lambda x, y: _peak(x - y) / _range(x)),
        ("mean square by variance", "mean((x - y)^2) / var(x)", lambda x, y: _mse(x, y) / _std(x) ** 2),
        ("rms by deviation", "rms(x - y) / std(x)", lambda x, y: _rmse(x, y) / _std(x)),
        ("mean absolute by deviation", "mean|x - y| / std(x)", lambda x, y: _mae(x, y) / _std(x)),
        ("variance of error", "var(x - y) / var(x)", lambda x, y: _std(x - y) ** 2 / _std(x) ** 2),
        ("deviation of error", "std(x - y) / std(x)", lambda x, y: _std(x - y) / _std(x)),
        (
            "energy, symmetric",
            "||x - y||^2 / (||x||^2 + ||y||^2)",
            lambda x, y: _square(x - y) / (_square(x) + _square(y)),
        ),
        ("energy, geometric", "||x - y||^2 / (||x|| ||y||)", lambda x, y: _square(x - y) / (_norm(x) * _norm(y))),
        ("2-norm, symmetric", "||x - y|| / (||x|| + ||y||)", lambda x, y: _norm(x - y) / (_norm(x) + _norm(y))),
        ("1-norm, symmetric", "|x - y|_1 / (|x|_1 + |y|_1)", lambda x, y: _norm1(x - y) / (_norm1(x) + _norm1(y))),
        ("cosine", "1 - cos(x, y)", lambda x, y: 1.0 - _cosine(x, y)),
        ("correlation", "1 - corr(x, y)", lambda x, y: 1.0 - _correlation(x, y)),
        ("cosine squared", "1 - cos(x, y)^2", lambda x, y: 1.0 - _cosine(x, y) ** 2),
        ("correlation squared", "1 - corr(x, y)^2", lambda x, y: 1.0 - _correlation(x, y) ** 2),
        ("unit vectors", "||x/||x|| - y/||y|| ||", lambda x, y: _norm(_unit(x) - _unit(y))),
        (
            "mean square, 0 to 1",
            "mean((n(x) - n(y))^2), n: range 0 to 1",
            lambda x, y: _mse(*map(_zero_to_one, (x, y))),
        ),
        ("rms, 0 to 1", "rms(n(x) - n(y)), n: range 0 to 1", lambda x, y: _rmse(*map(_zero_to_one, (x, y)))),
        ("area", "| |x|_1 - |y|_1 | / |x|_1", lambda x, y: np.abs(_norm1(x) - _norm1(y)) / _norm1(x)),
        (
            "energy difference",
            "| ||x||^2 - ||y||^2 | / ||x||^2",
            lambda x, y: np.abs(_square(x) - _square(y)) / _square(x),
        ),
    )
    return tuple(Candidate("time", name, formula, error) for name, formula, error in rows)


#: Spectrum kinds: name, symbols of the actual and the rebuilt spectrum, function.
_KINDS: tuple[tuple[str, str, str, Callable[[Array], Array]], ...] = (
    ("signed", "X", "Y", lambda s: s),
    ("absolute", "|X|", "|Y|", np.abs),
    ("power", "X^2", "Y^2", np.square),
    ("log", "log(1+|X|)", "log(1+|Y|)", lambda s: np.log1p(np.abs(s))),
)

#: Normalisations: name, formula of a normalised spectrum S, function.
_NORMALISATIONS: tuple[tuple[str, str, Callable[[Array], Array]], ...] = (
    ("none", "{S}", lambda s: s),
    ("2-norm", "{S}/||{S}||", _unit),
    ("1-norm", "{S}/|{S}|_1", lambda s: s / _norm1(s)[..., None]),
    ("maximum", "{S}/max({S})", lambda s: s / np.max(s, -1, keepdims=True)),
    ("0 to 1", "n({S})", _zero_to_one),
    ("sum", "{S}/sum({S})", lambda s: s / np.sum(s, -1, keepdims=True)),
)

#: Distances of two normalised spectra: name, formula with D their difference, function of D.
_DISTANCES: tuple[tuple[str, str, Callable[[Array], Array]], ...] = (
    ("2-norm", "||{D}||", _norm),
    ("1-norm", "|{D}|_1", _norm1),
    ("maximum", "max|{D}|", _peak),
    ("squared 2-norm", "||{D}||^2", _square),
    ("mean square", "mean(({D})^2)", lambda d: _square(d) / d.shape[-1]),
    ("rms", "rms({D})", lambda d: np.sqrt(_square(d) / d.shape[-1])),
    ("mean absolute", "mean|{D}|", lambda d: _norm1(d) / d.shape[-1]),
)

#: Errors of two spectra S and T that need no normalisation: a factor common to both cancels.
_SCALE_FREE: tuple[tuple[str, str, Pair], ...] = (
    ("relative 2-norm", "||{S} - {T}|| / ||{S}||", lambda s, t: _norm(s - t) / _norm(s)),
    ("relative 1-norm", "|{S} - {T}|_1 / |{S}|_1", lambda s, t: _norm1(s - t) / _norm1(s)),
    ("relative maximum", "max|{S} - {T}| / max|{S}|", lambda s, t: _peak(s - t) / _peak(s)),
    ("relative energy", "||{S} - {T}||^2 / ||{S}||^2", lambda s, t: _square(s - t) / _square(s)),
    ("cosine", "1 - cos({S}, {T})", lambda s, t: 1.0 - _cosine(s, t)),
    ("correlation", "1 - corr({S}, {T})", lambda s, t: 1.0 - _correlation(s, t)),
    ("angle", "2 acos(cos({S}, {T})) / pi", lambda s, t: 2.0 / np.pi * np.arccos(np.clip(_cosine(s, t), -1.0, 1.0))),
)


def _product(
    kind: Callable[[Array], Array], unit: Callable[[Array], Array], distance: Callable[[Array], Array]
) -> Pair:
    return lambda s, t: distance(unit(kind(s)) - unit(kind(t)))


def _of_kind(kind: Callable[[Array], Array], error: Pair) -> Pair:
    return lambda s, t: error(kind(s), kind(t))


def frequency_candidates() -> tuple[Candidate, ...]:
    """Error formulas on the DCT-II spectra: kind | normalisation | distance.

    The sum differs from the 1-norm for the signed spectrum only, so it is tried there only.
    """
    products = [
        Candidate(
            "frequency",
            f"{kind} | {norm} | {distance}",
            form.format(D=f"{shape.format(S=x)} - {shape.format(S=y)}"),
            _product(of, unit, measure),
        )
        for kind, x, y, of in _KINDS
        for norm, shape, unit in _NORMALISATIONS
        if norm != "sum" or kind == "signed"
        for distance, form, measure in _DISTANCES
    ]
    scale_free = [
        Candidate("frequency", f"{kind} | - | {name}", form.format(S=x, T=y), _of_kind(of, error))
        for kind, x, y, of in _KINDS
        for name, form, error in _SCALE_FREE
    ]
    return (*products, *scale_free)
