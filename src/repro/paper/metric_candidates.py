"""Candidate error formulas for the two factors of ``metr2ev``, whose listing (Algorithm 2) is lost.

According to Section IV-C the product of both factors is "adjusted with a power of 0.4": each factor is
(1 - error)^0.4 with an unknown error.

A frequency candidate is spectrum kind x normalisation x distance, for example ``signed | 2-norm | 2-norm`` for
||X/||X|| - Y/||Y|| ||. The DCT-II of Eq. 5 is orthonormal and preserves inner products (Parseval), so this error is
sqrt(2 - 2 cos(x, y)) of the signals and equals the time candidate ``unit vectors``. The errors of absolute, power and
logarithmic spectra are no functions of the cosine. Formulas share norms and differences, which a `Pair` computes once.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from repro.model.parameters import Array

Factor = Literal["time", "frequency"]


class Signal:
    """A signal or spectrum of shape (..., 2, N), and sums over its samples, each of shape (..., 2)."""

    def __init__(self, values: Array) -> None:
        self.values, self.n = values, values.shape[-1]
        self.low, self.high, self.mean = (np.asarray(reduce(values, -1)) for reduce in (np.min, np.max, np.mean))
        self.peak = np.maximum(self.high, -self.low)
        self.norm1 = np.asarray(np.abs(values).sum(-1))
        self.square = np.asarray(np.einsum("...n,...n->...", values, values))
        self.norm = np.sqrt(self.square)
        self.mean_square, self.mean_absolute = np.asarray(self.square / self.n), np.asarray(self.norm1 / self.n)
        self.rms = np.sqrt(self.mean_square)

    def normalised(self, name: str) -> Array:
        """Normalise the values in one of the ways of `_NORMALISATIONS`."""
        if name == "0 to 1":
            return np.asarray((self.values - self.low[..., np.newaxis]) / (self.high - self.low)[..., np.newaxis])
        scale = {"2-norm": self.norm, "1-norm": self.norm1, "maximum": self.high, "sum": self.n * self.mean}[name]
        return np.asarray(self.values / scale[..., np.newaxis])


class Pair:
    """Two signals or spectra: `x` is the actual one, `y` the rebuilt one."""

    def __init__(self, x: Array, y: Array) -> None:
        self.x, self.y = Signal(x), Signal(y)
        self.range = np.asarray(self.x.high - self.x.low)
        #: Largest magnitude of both joints, the normalisation of torque in Eq. 8.
        self.arm_peak = np.max(self.x.peak, -1, keepdims=True)
        self._of_kind: dict[str, Pair] = {}
        self._normalised: dict[str, Signal] = {}

    @cached_property
    def error(self) -> Signal:
        """Difference of the signals."""
        return Signal(self.x.values - self.y.values)

    @cached_property
    def cosine(self) -> Array:
        """Cosine of the angle between the signals."""
        product = np.einsum("...n,...n->...", self.x.values, self.y.values)
        return np.asarray(product / (self.x.norm * self.y.norm))

    @cached_property
    def centred(self) -> "Pair":
        """Signals without their means: their rms is a standard deviation and their cosine the correlation."""
        return Pair(*(signal.values - signal.mean[..., np.newaxis] for signal in (self.x, self.y)))

    def of_kind(self, kind: str) -> "Pair":
        """Spectra of another kind."""
        if kind not in self._of_kind:
            self._of_kind[kind] = Pair(*(_KINDS[kind][2](signal.values) for signal in (self.x, self.y)))
        return self._of_kind[kind]

    def normalised(self, name: str) -> Signal:
        """Difference of the normalised signals."""
        if name == "none":
            return self.error
        if name not in self._normalised:
            self._normalised[name] = Signal(self.x.normalised(name) - self.y.normalised(name))
        return self._normalised[name]


Measure = Callable[[Pair], Array]


@dataclass(frozen=True)
class Candidate:
    """One error formula."""

    factor: Factor  # factor of ``metr2ev`` that it may explain
    name: str  # short name, unique within the factor
    formula: str  # readable; x and X are the actual signal and its DCT-II spectrum, y and Y the rebuilt ones
    measure: Measure  # error of a pair of signals (time) or spectra (frequency), shape (..., 2); 0 for equal arguments


_TIME: tuple[tuple[str, str, Measure], ...] = (
    ("mean square", "mean((x - y)^2), in the signal's unit squared", lambda p: p.error.mean_square),
    ("rms", "rms(x - y), in the signal's unit", lambda p: p.error.rms),
    ("mean absolute", "mean|x - y|, in the signal's unit", lambda p: p.error.mean_absolute),
    ("maximum", "max|x - y|, in the signal's unit", lambda p: p.error.peak),
    ("mean difference", "|mean(x) - mean(y)|, in the signal's unit", lambda p: np.abs(p.x.mean - p.y.mean)),
    ("energy", "||x - y||^2 / ||x||^2", lambda p: p.error.square / p.x.square),
    ("relative 2-norm", "||x - y|| / ||x||", lambda p: p.error.norm / p.x.norm),
    ("relative 1-norm", "|x - y|_1 / |x|_1", lambda p: p.error.norm1 / p.x.norm1),
    ("relative maximum", "max|x - y| / max|x|", lambda p: p.error.peak / p.x.peak),
    ("mean square by peak", "mean((x - y)^2) / max|x|^2", lambda p: p.error.mean_square / p.x.peak**2),
    ("rms by peak", "rms(x - y) / max|x|", lambda p: p.error.rms / p.x.peak),
    ("mean absolute by peak", "mean|x - y| / max|x|", lambda p: p.error.mean_absolute / p.x.peak),
    ("mean square by common peak", "mean((x - y)^2) / peak(x1, x2)^2", lambda p: p.error.mean_square / p.arm_peak**2),
    ("rms by common peak", "rms(x - y) / peak(x1, x2)", lambda p: p.error.rms / p.arm_peak),
    ("mean absolute by common peak", "mean|x - y| / peak(x1, x2)", lambda p: p.error.mean_absolute / p.arm_peak),
    ("mean square by range", "mean((x - y)^2) / range(x)^2", lambda p: p.error.mean_square / p.range**2),
    ("rms by range", "rms(x - y) / range(x)", lambda p: p.error.rms / p.range),
    ("mean absolute by range", "mean|x - y| / range(x)", lambda p: p.error.mean_absolute / p.range),
    ("maximum by range", "max|x - y| / range(x)", lambda p: p.error.peak / p.range),
    ("mean square by variance", "mean((x - y)^2) / var(x)", lambda p: p.error.square / p.centred.x.square),
    ("rms by deviation", "rms(x - y) / std(x)", lambda p: p.error.rms / p.centred.x.rms),
    ("mean absolute by deviation", "mean|x - y| / std(x)", lambda p: p.error.mean_absolute / p.centred.x.rms),
    ("variance of error", "var(x - y) / var(x)", lambda p: p.centred.error.square / p.centred.x.square),
    ("deviation of error", "std(x - y) / std(x)", lambda p: p.centred.error.norm / p.centred.x.norm),
    ("energy, symmetric", "||x - y||^2 / (||x||^2 + ||y||^2)", lambda p: p.error.square / (p.x.square + p.y.square)),
    ("energy, geometric", "||x - y||^2 / (||x|| ||y||)", lambda p: p.error.square / (p.x.norm * p.y.norm)),
    ("2-norm, symmetric", "||x - y|| / (||x|| + ||y||)", lambda p: p.error.norm / (p.x.norm + p.y.norm)),
    ("1-norm, symmetric", "|x - y|_1 / (|x|_1 + |y|_1)", lambda p: p.error.norm1 / (p.x.norm1 + p.y.norm1)),
    ("cosine", "1 - cos(x, y)", lambda p: 1.0 - p.cosine),
    ("correlation", "1 - corr(x, y)", lambda p: 1.0 - p.centred.cosine),
    ("cosine squared", "1 - cos(x, y)^2", lambda p: 1.0 - p.cosine**2),
    ("correlation squared", "1 - corr(x, y)^2", lambda p: 1.0 - p.centred.cosine**2),
    ("unit vectors", "||x/||x|| - y/||y|| ||", lambda p: p.normalised("2-norm").norm),
    ("mean square, 0 to 1", "mean((n(x) - n(y))^2), n: range 0 to 1", lambda p: p.normalised("0 to 1").mean_square),
    ("rms, 0 to 1", "rms(n(x) - n(y)), n: range 0 to 1", lambda p: p.normalised("0 to 1").rms),
    ("area", "| |x|_1 - |y|_1 | / |x|_1", lambda p: np.abs(p.x.norm1 - p.y.norm1) / p.x.norm1),
    ("energy difference", "| ||x||^2 - ||y||^2 | / ||x||^2", lambda p: np.abs(p.x.square - p.y.square) / p.x.square),
)


#: Kinds of spectrum: symbols of the actual and the rebuilt spectrum, and the function that computes it.
_KINDS: dict[str, tuple[str, str, Callable[[Array], Array]]] = {
    "signed": ("X", "Y", lambda s: s),
    "absolute": ("|X|", "|Y|", np.abs),
    "power": ("X^2", "Y^2", np.square),
    "log": ("log(1+|X|)", "log(1+|Y|)", lambda s: np.log1p(np.abs(s))),
}

#: Formula of a normalised spectrum S, by the name of the normalisation.
_NORMALISATIONS: dict[str, str] = {
    "none": "{S}",
    "2-norm": "{S}/||{S}||",
    "1-norm": "{S}/|{S}|_1",
    "maximum": "{S}/max({S})",
    "0 to 1": "n({S})",
    "sum": "{S}/sum({S})",
}

#: Distances of two normalised spectra: name, formula with D their difference, function of D.
_DISTANCES: tuple[tuple[str, str, Callable[[Signal], Array]], ...] = (
    ("2-norm", "||{D}||", lambda d: d.norm),
    ("1-norm", "|{D}|_1", lambda d: d.norm1),
    ("maximum", "max|{D}|", lambda d: d.peak),
    ("squared 2-norm", "||{D}||^2", lambda d: d.square),
    ("mean square", "mean(({D})^2)", lambda d: d.mean_square),
    ("rms", "rms({D})", lambda d: d.rms),
    ("mean absolute", "mean|{D}|", lambda d: d.mean_absolute),
)

#: Errors of two spectra S and T that do not change when both are scaled alike.
_SCALE_FREE: tuple[tuple[str, str, Measure], ...] = (
    ("relative 2-norm", "||{S} - {T}|| / ||{S}||", lambda p: p.error.norm / p.x.norm),
    ("relative 1-norm", "|{S} - {T}|_1 / |{S}|_1", lambda p: p.error.norm1 / p.x.norm1),
    ("relative maximum", "max|{S} - {T}| / max|{S}|", lambda p: p.error.peak / p.x.peak),
    ("relative energy", "||{S} - {T}||^2 / ||{S}||^2", lambda p: p.error.square / p.x.square),
    ("cosine", "1 - cos({S}, {T})", lambda p: 1.0 - p.cosine),
    ("correlation", "1 - corr({S}, {T})", lambda p: 1.0 - p.centred.cosine),
    ("angle", "2 acos(cos({S}, {T})) / pi", lambda p: 2.0 / np.pi * np.arccos(np.clip(p.cosine, -1.0, 1.0))),
)


def _of_spectra(kind: str, measure: Measure) -> Measure:
    return lambda p: measure(p.of_kind(kind))


def _of_normalised(normalisation: str, distance: Callable[[Signal], Array]) -> Measure:
    return lambda p: distance(p.normalised(normalisation))


def _frequency_candidates() -> Iterator[Candidate]:
    """Error formulas on the DCT-II spectra: kind | normalisation | distance."""
    for kind, (x, y, _) in _KINDS.items():
        for norm, shape in _NORMALISATIONS.items():
            # Division by the sum differs from division by the 1-norm for the signed spectrum only.
            for name, form, distance in _DISTANCES if norm != "sum" or kind == "signed" else ():
                formula = form.format(D=f"{shape.format(S=x)} - {shape.format(S=y)}")
                measure = _of_spectra(kind, _of_normalised(norm, distance))
                yield Candidate("frequency", f"{kind} | {norm} | {name}", formula, measure)
    for kind, (x, y, _) in _KINDS.items():
        for name, form, error in _SCALE_FREE:
            formula = form.format(S=x, T=y)
            yield Candidate("frequency", f"{kind} | - | {name}", formula, _of_spectra(kind, error))


#: Every candidate of both factors, time first.
CANDIDATES = (*(Candidate("time", *entry) for entry in _TIME), *_frequency_candidates())
