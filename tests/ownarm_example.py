"""A made-up result of `repro identify`: three methods, two validation logs, one parameter that is not excited."""

import numpy as np

from repro.identification.filtering import Cutoff
from repro.logs.diagnostics import Description
from repro.model.parameters import DESCRIPTIONS, NAMES, UNITS
from repro.ownarm.result import Curves, Excitation, MethodResult, Parameter, Preparation, Result, Score, Signals

BETA = (0.1213, 0.0701, 0.02342, 3.235, 1.134, 0.0651, 0.0122, 0.2213, 0.1304)
ERRORS = (0.0019, 0.0011, 0.00064, 0.021, 0.0093, 0.012, 0.0151, 0.0088, 0.0059)
VERDICTS = (
    "known to 3 %",
    "known to 3 %",
    "known to 5 %",
    "known to 1.3 %",
    "known to 1.6 %",
    "known to 36 %",
    "not excited by this motion",
    "known to 8 %",
    "known to 9 %",
)
LOGS = ("excitation.csv", "ramp_1.csv", "ramp_2.csv")


def parameters(factor=1.0, b2=None, claims=True):
    """The nine, all but one a common factor from the made-up truth."""
    values = [factor * value for value in BETA]
    if b2 is not None:
        values[6] = b2
    verdicts = VERDICTS if claims else ("no interval claimed",) * 9
    made = []
    for name, unit, words, value, error, verdict in zip(
        NAMES, UNITS, DESCRIPTIONS, values, ERRORS, verdicts, strict=True
    ):
        spread = (error, value - 1.96 * error, value + 1.96 * error) if claims else (None, None, None)
        made.append(Parameter(name, unit, words, value, *spread, verdict))
    return tuple(made)


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
        "validation": (
            score(LOGS[1], 0.094 * worse, 0.171 * worse, position),
            score(LOGS[2], 0.097 * worse, 0.183 * worse, position),
        ),
        "halves": (score("second half", 0.0571 * worse, 0.117 * worse), score("first half", 0.0556 * worse, 0.0957)),
        "whiteness": (0.942, 0.957),
        "notes": (f"{title}: 11 % of the samples have a reduced weight.",),
        "citation": f"{name}Source",
    }
    return MethodResult(**{**given, **changes})


def example_result(**changes):
    """A result; `changes` replace fields of `Result`."""
    description = Description(
        LOGS[0],
        (("Samples", "22 524 at 300.0 Hz"), ("Length", "75.1 s"), ("Motion, joint 1", "-2.10 to 2.94 rad")),
        ("Torque was read in N m.", "Positions were unwrapped."),
        ("Torque of joint 2 is at its limit in 0.8 % of the samples.",),
    )
    ramps = tuple(
        Description(name, (("Samples", "2 000 at 200.0 Hz"), ("Length", "10.0 s"), ("Gaps", "none")), (), ())
        for name in LOGS[1:]
    )
    methods = (
        method("ols", "Ordinary least squares", 1.21, None, fit=score(LOGS[0], 0.0569, 0.1064),
               parameters=parameters(1.03, -0.0304), consistent=False,
               why_not_consistent="b2 is negative: friction would drive the arm"),
        method("consistent", "Physically consistent least squares"),
        method("cnn", "Algorithm 1 with refinement", 1.1, (0.036, 0.09), parameters=parameters(0.96, 0.016, False),
               claims_intervals=False, halves=()),
    )  # fmt: skip
    given = {
        "arm": "Double pendulum A.0",
        "simulated": False,
        "log": description,
        "validation_logs": ramps,
        "preparation": Preparation(
            "zero-phase DCT pair", 5.2, "the recorded position is above its noise up to here",
            0.0051, 20.0, 60.0, 4470, 0.3,
        ),
        "excitation": Excitation(
            9, 41.7, (0.12, 0.051, 0.031, 0.81, 0.33, 0.04, 0.009, 0.11, 0.14), (-0.94, -0.97), ("b2",), NAMES
        ),
        "methods": methods,
        "recommended": "consistent",
        "reason": "smallest torque error on the validation logs among the physically consistent methods",
        "warnings": ("Viscous and Coulomb friction are hard to tell apart: the motion is slow.",),
    }  # fmt: skip
    return Result(**{**given, **changes})


def _signals(name, duration, rate, rng):
    t = np.arange(0.0, duration, 1.0 / rate)
    phase = 2.0 * np.pi * t
    tau = np.stack([3.0 * np.sin(0.4 * phase) + 0.5 * np.sin(1.3 * phase), 1.1 * np.sin(0.7 * phase + 0.4)])
    tau += 0.15 * np.sign(np.cos(0.55 * phase))
    rebuilt = {}
    for place, known in enumerate(("ols", "consistent", "cnn")):
        wander = np.cumsum(rng.normal(size=tau.shape), axis=-1) / np.sqrt(t.size)
        rebuilt[known] = (1.0 + 0.02 * place) * tau + 0.1 * wander

    def amplitude(signal):
        return 2.0 / t.size * np.abs(np.fft.rfft(signal, axis=-1))

    return Signals(
        name, t, tau, rebuilt, np.fft.rfftfreq(t.size, 1.0 / rate), amplitude(tau),
        {known: amplitude(signal) for known, signal in rebuilt.items()},
    )  # fmt: skip


def example_curves(duration=12.0):
    """Curves that go with `example_result`."""
    rng = np.random.default_rng(5)
    frequency = np.arange(400) / 8.0
    position = 1e4 / (1.0 + (frequency / 0.8) ** 4) + rng.random((2, 400))
    coherence = 1.0 / (1.0 + (frequency / 5.2) ** 4) * (0.95 + 0.05 * rng.random((2, 400)))
    reason = "above 5.2 Hz Eq. 1 explains less than half of the torque's power"
    return Curves(
        tuple(_signals(name, length, 60.0, rng) for name, length in zip(LOGS, (duration, 10.0, 10.0), strict=True)),
        Cutoff(5.2, reason, frequency, coherence, position, 10.0),
    )
