"""A made-up result of `repro identify`: three methods, a validation log, one parameter that is not excited."""

import io

import numpy as np
from PIL import Image

from repro.fitting.result import Curves, Excitation, MethodResult, Parameter, Preparation, Result, Score, Signals
from repro.identification.filtering import Cutoff
from repro.logs.diagnostics import Description
from repro.model.parameters import DESCRIPTIONS, NAMES, UNITS

BETA = (0.1213, 0.0701, 0.02342, 3.235, 1.134, 0.0651, 0.0122, 0.2213, 0.1304)
ERRORS = (0.0019, 0.0011, 0.00064, 0.021, 0.0093, 0.012, 0.0151, 0.0088, 0.0059)
LOGS = ("excitation.csv", "ramp.csv")


def parameters(factor=1.0, b2=BETA[6], claims=True):
    """The nine, all but b2 a common factor from the made-up truth."""
    rows = []
    for name, unit, words, value, error in zip(NAMES, UNITS, DESCRIPTIONS, BETA, ERRORS, strict=True):
        estimate = b2 if name == "b2" else factor * value
        spread = (error, estimate - 1.96 * error, estimate + 1.96 * error) if claims else (None, None, None)
        verdict = "not excited by this motion" if name == "b2" else "known to 3 %" if claims else "no interval claimed"
        rows.append(Parameter(name, unit, words, estimate, *spread, verdict))
    return tuple(rows)


def png(height=10):
    file = io.BytesIO()
    Image.new("RGB", (20, height)).save(file, "PNG")
    return file.getvalue()


def score(log, one, two, position=(0.031, 0.087)):
    return Score(log, (one, two), (1.0 - one**2, 1.0 - two**2), position)


def method(name, title, worse=1.0, position=(0.031, 0.087), **changes):
    """A method whose errors are this many times the best."""
    given = {
        "method": name,
        "title": title,
        "parameters": parameters(),
        "claims_intervals": True,
        "consistent": True,
        "why_not_consistent": "",
        "fit": score(LOGS[0], 0.0574 * worse, 0.107 * worse),
        "validation": (score(LOGS[1], 0.094 * worse, 0.171 * worse, position),),
        "halves": (score("second half", 0.0571 * worse, 0.117 * worse), score("first half", 0.0556 * worse, 0.0957)),
        "whiteness": (0.942, 0.957),
        "notes": (f"{title}: 11 % of the samples have a reduced weight.",),
        "citation": "cnn_identification",
    }
    return MethodResult(**{**given, **changes})


def example_result(**changes):
    """A result; `changes` replace fields of `Result`."""
    facts = (("Samples", "22 524 at 300.0 Hz"), ("Length", "75.1 s"), ("Motion, joint 1", "-2.10 to 2.94 rad"))
    methods = (
        method("ols", "Ordinary least squares", 1.21, None, fit=score(LOGS[0], 0.0569, 0.1064),
               parameters=parameters(1.03, -0.0304), consistent=False,
               why_not_consistent="b2 is negative: friction would drive the arm"),
        method("consistent", "Physically consistent least squares"),
        method("cnn", "Algorithm 1 with refinement", 1.1, (0.036, 0.09), parameters=parameters(0.96, 0.016, False),
               claims_intervals=False, halves=()),
    )  # fmt: skip
    fractions = (0.12, 0.051, 0.031, 0.81, 0.33, 0.04, 0.009, 0.11, 0.14)
    given = {
        "arm": "Double pendulum A.0",
        "simulated": False,
        "log": Description(LOGS[0], facts, ("Positions were unwrapped.",), ("The torque is at its limit.",)),
        "validation_logs": (Description(LOGS[1], (("Samples", "2 000 at 200.0 Hz"), ("Gaps", "none")), (), ()),),
        "preparation": Preparation("zero-phase DCT pair", 5.2, "a reason", 0.0051, 20.0, None, 60.0, 4470, 0.3),
        "excitation": Excitation(9, 41.7, fractions, (-0.94, -0.97), ("b2",), NAMES),
        "methods": methods,
        "recommended": "consistent",
        "reason": "smallest torque error on the validation logs among the physically consistent methods",
        "warnings": ("Viscous and Coulomb friction are hard to tell apart: the motion is slow.",),
    }
    return Result(**{**given, **changes})


def _signals(name, duration, rng):
    t = np.arange(0.0, duration, 1.0 / 60.0)
    phase = 2.0 * np.pi * t
    tau = np.stack([3.0 * np.sin(0.4 * phase) + 0.5 * np.sin(1.3 * phase), 1.1 * np.sin(0.7 * phase + 0.4)])
    tau += 0.15 * np.sign(np.cos(0.55 * phase))
    torques = {"measured": tau}
    for place, known in enumerate(("ols", "consistent", "cnn")):
        wander = np.cumsum(rng.normal(size=tau.shape), axis=-1) / np.sqrt(t.size)
        torques[known] = (1.0 + 0.02 * place) * tau + 0.1 * wander
    spectra = {known: 2.0 / t.size * np.abs(np.fft.rfft(torque, axis=-1)) for known, torque in torques.items()}
    frequency = np.fft.rfftfreq(t.size, 1.0 / 60.0)
    return Signals(name, t, torques.pop("measured"), torques, frequency, spectra.pop("measured"), spectra)


def example_curves(duration=12.0):
    """Curves that go with `example_result`."""
    rng = np.random.default_rng(5)
    frequency = np.arange(400) / 8.0
    position = 1e4 / (1.0 + (frequency / 0.8) ** 4) + rng.random((2, 400))
    coherence = 1.0 / (1.0 + (frequency / 5.2) ** 4) * (0.95 + 0.05 * rng.random((2, 400)))
    signals = tuple(_signals(name, length, rng) for name, length in zip(LOGS, (duration, 10.0), strict=True))
    return Curves(signals, Cutoff(5.2, "a reason", frequency, coherence, position, 10.0))
