"""The result of `repro identify`: plain dataclasses, written as JSON and drawn by the report."""

from collections.abc import Iterator
from dataclasses import dataclass, field

from repro.identification.calibration import CalibrationError
from repro.identification.extra_terms import ROTOR, ExtraTerm
from repro.identification.filtering import Cutoff
from repro.logs.diagnostics import Description
from repro.model.parameters import Array

URDF_FILE, MJCF_FILE = EXPORTS = ("arm.urdf", "arm.xml")  # models of the arm for simulators
#: Halves of a log, each predicted from the other. Methods without intervals would train a network for each.
HALVES = ("second half", "first half")


@dataclass(frozen=True)
class Parameter:
    """One parameter as one method estimates it."""

    name: str  # name, unit and description as in Table 2
    unit: str
    description: str
    estimate: float  # SI
    standard_error: float | None  # block bootstrap; None for a method that claims no intervals, as the next two
    low: float | None  # ends of the 95 % interval
    high: float | None
    verdict: str  # such as "known to 3 %", "not excited by this motion"
    prior_weight: float = 0.0  # by how much the estimate follows the mean of its own prior, 0 to 1


@dataclass(frozen=True)
class Score:
    """How well a method's parameters predict one log."""

    log: str  # file name, or one of `HALVES`
    relative_rms: tuple[float, float]  # RMS torque error over RMS torque of each joint, fractions of 1
    similarity: tuple[float, float]  # total of ``metr2ev`` of each joint, fractions of 1
    position_rms: tuple[float, float] | None  # RMS error of the re-simulated position, rad; None if it fails


@dataclass(frozen=True)
class MethodResult:
    """Estimate and scores of one method."""

    method: str  # name on the command line
    title: str
    parameters: tuple[Parameter, ...]  # the nine
    claims_intervals: bool
    consistent: bool  # inertia matrix positive definite, no friction negative, I2 g1 g2 not negative
    why_not_consistent: str  # the conditions that fail; empty if none does
    fit: Score  # on the log itself, the samples it was fitted to
    validation: tuple[Score, ...]  # on the logs given with ``--validate``
    halves: tuple[Score, ...]  # each half predicted from the other; empty for a method too slow for it
    whiteness: tuple[float, float]  # autocorrelation of each joint's residual at a lag of one period of the cut-off
    notes: tuple[str, ...]  # the method's own: weights, rejected samples, shrinkage chosen
    citation: str  # BibTeX key of the method's source

    @property
    def scores(self) -> Iterator[tuple[str, Score]]:
        """Every score with its kind: ``fit``, ``half``, ``log`` (left out of several) or ``validation``."""
        yield "fit", self.fit
        for score in self.halves:
            yield "half" if score.log in HALVES else "log", score
        for score in self.validation:
            yield "validation", score


@dataclass(frozen=True)
class Excitation:
    """What the motion can show, whatever the method."""

    rank: int  # numerical rank of the regressor with columns of unit length; 9 if all parameters are identifiable
    condition: float  # its condition number
    share: tuple[float, ...]  # (9,), RMS torque of each parameter over the RMS torque, at the recommended estimate
    friction_correlation: tuple[float, float]  # correlation of viscous and Coulomb friction of each joint
    unexcited: tuple[str, ...]  # names of the parameters that the motion does not excite
    base_parameters: tuple[str, ...]  # identifiable combinations, such as "I1 + 0.31 I3"; the names if the rank is 9


@dataclass(frozen=True)
class Preparation:
    """How the signals were filtered."""

    filter: str
    cutoff: float  # Hz
    cutoff_reason: str
    delay: float  # shift of the torque that fits the motion best, s; positive: it acts later than recorded
    friction_steepness: float  # lambda of Eq. 1, s/rad
    stribeck_speed: float | None  # at which Stribeck friction has fallen to 1/e, rad/s; None if none is subtracted
    rate: float  # rate of the samples that methods see, Hz
    samples: int  # their number
    cut: float  # length left out at each end, s


@dataclass(frozen=True)
class RecoveredParameter:
    """One parameter in the self-test: true value, estimates from the draws, and coverage."""

    name: str
    true: float
    median: float
    low: float  # range of the estimates
    high: float
    hold: int  # intervals that contain the true value
    intervals: int  # intervals claimed


@dataclass(frozen=True)
class SelfTest:
    """Estimates of one method from synthetic logs whose parameters are known."""

    method: str
    draws: int  # number of synthetic logs
    parameters: tuple[RecoveredParameter, ...]  # the nine
    error: tuple[float, float]  # relative RMS torque error of each joint, median of the draws
    real: tuple[float, float]  # the same on the log itself
    noise: tuple[float, float]  # share of the squared `real` that noise explains, at most 1
    model_wrong: bool  # whether noise explains less than half of it, of either joint


@dataclass(frozen=True)
class SingleFit:
    """One of several fitted logs, fitted by itself with the recommended method."""

    log: str  # file name
    parameters: tuple[Parameter, ...]  # the nine


@dataclass(frozen=True)
class Change:
    """One parameter in an earlier result and in this one."""

    name: str
    unit: str
    before: float
    now: float
    agree: bool | None  # whether both intervals explain the difference; None if one has none


@dataclass(frozen=True)
class Spread:
    """One parameter in each of several logs by itself."""

    name: str
    unit: str
    together: float  # estimate from all logs
    estimates: tuple[float, ...]  # from each log, in the order of `Result.runs`
    range: float  # largest less smallest
    agree: bool | None  # whether the 95 % intervals have a common value; None with fewer than two


@dataclass(frozen=True)
class Result:
    """Everything that the JSON file contains."""

    arm: str  # name of the arm
    simulated: bool  # whether the simulated board made the log
    log: Description  # the log that was fitted
    validation_logs: tuple[Description, ...]
    preparation: Preparation
    excitation: Excitation
    methods: tuple[MethodResult, ...]  # in the order requested
    recommended: str  # name of the method whose parameters to use
    reason: str
    warnings: tuple[str, ...] = ()  # about the result as a whole
    more_logs: tuple[Description, ...] = ()  # logs that were fitted together with `log`
    # Of `log` and of each of `more_logs`: calibration errors that were corrected before the fit, detection limits of
    # those that the log could contain undetected, and terms beyond Eq. 1 that were subtracted or would help: those of
    # the arm, the same for each log.
    calibration_errors: tuple[tuple[CalibrationError, ...], ...] = ()
    calibration_limits: tuple[dict[str, float | None], ...] = ()
    friction: tuple[tuple[ExtraTerm, ...], ...] = ()
    # Scores of the recommended parameters in an export that cannot contain a term beyond Eq. 1, by the file's name.
    exports: dict[str, tuple[Score, ...]] = field(default_factory=dict)
    selftest: SelfTest | None = None
    prior: dict[str, dict[str, float]] = field(default_factory=dict)  # value and sd of each parameter with a prior
    runs: tuple[SingleFit, ...] = ()  # each of several logs by itself
    changes: tuple[Change, ...] = ()  # since an earlier result that was given

    @property
    def spread(self) -> tuple[Spread, ...]:
        """The nine parameters from log to log; empty unless two logs could be fitted by themselves."""
        rows = []
        for together, *alone in zip(self.best.parameters, *(run.parameters for run in self.runs), strict=True):
            estimates = tuple(p.estimate for p in alone)
            ends = [(p.low, p.high) for p in alone if p.low is not None and p.high is not None]
            agree = max(low for low, _ in ends) <= min(high for _, high in ends) if len(ends) > 1 else None
            span = max(estimates, default=0.0) - min(estimates, default=0.0)
            rows.append(Spread(together.name, together.unit, together.estimate, estimates, span, agree))
        return tuple(rows) if len(self.runs) > 1 else ()

    @property
    def terms(self) -> tuple[ExtraTerm, ...]:
        """The terms beyond Eq. 1."""
        return self.friction[0] if self.friction else ()

    def left_out_of(self, export: str) -> tuple[str, ...]:
        """Names of the terms of the arm that an export cannot contain: MJCF has the rotor, URDF none."""
        return tuple(
            term.name for term in self.terms if term.taken and not (term.kind == ROTOR and export == MJCF_FILE)
        )

    @property
    def best(self) -> MethodResult:
        """The recommended method."""
        return next(method for method in self.methods if method.method == self.recommended)

    @property
    def fitted_logs(self) -> tuple[Description, ...]:
        """The logs that were fitted."""
        return (self.log, *self.more_logs)

    @property
    def all_warnings(self) -> tuple[str, ...]:
        """Warnings about each log, with its name if there are several, and about the result."""
        logs = (*self.fitted_logs, *self.validation_logs)
        about_logs = (f"{log.name}: {line}" if len(logs) > 1 else line for log in logs for line in log.warnings)
        return (*about_logs, *self.warnings)


@dataclass(frozen=True)
class Signals:
    """Torques of one log over time (2, n) and frequency (2, m), N m; the dictionaries have a torque for each method."""

    name: str  # file name
    t: Array  # (n,), s
    tau: Array  # measured and filtered
    rebuilt: dict[str, Array]
    frequency: Array  # (m,), Hz
    tau_spectrum: Array
    rebuilt_spectrum: dict[str, Array]


@dataclass(frozen=True)
class Curves:
    """Curves of a report: of the fitted logs first, then of the validation logs."""

    signals: tuple[Signals, ...] = ()
    cutoff: Cutoff | None = None  # how the cut-off was chosen
