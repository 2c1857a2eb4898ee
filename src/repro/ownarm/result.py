"""What `repro identify` finds out: plain dataclasses, written as JSON and drawn by the report."""

from dataclasses import dataclass, field

from repro.identification.extra_terms import CalibrationError, FrictionTerm
from repro.identification.filtering import Cutoff
from repro.logs.diagnostics import Description
from repro.model.parameters import Array
from repro.ownarm.selftest import SelfTest

#: Halves of a log, each predicted from the other; methods without intervals would train a network for each.
HALVES = ("second half", "first half")


@dataclass(frozen=True)
class Parameter:
    """One parameter as one method finds it.

    Attributes
    ----------
    name, unit, description : str
        As in Table 2.
    estimate : float
        Value, SI.
    standard_error, low, high : float or None
        Block-bootstrap standard error and 95 % interval; None for a method that claims none.
    verdict : str
        In plain words: "known to 3 %", "not excited by this motion".
    """

    name: str
    unit: str
    description: str
    estimate: float
    standard_error: float | None
    low: float | None
    high: float | None
    verdict: str


@dataclass(frozen=True)
class Score:
    """How well a method's parameters predict one log.

    Attributes
    ----------
    log : str
        File name; "first half", "second half" where one half of the log is predicted from the other.
    relative_rms : tuple of 2 floats
        RMS torque error over RMS torque, of each joint, fractions of 1.
    similarity : tuple of 2 floats
        Total of ``metr2ev`` of each joint, fractions of 1.
    position_rms : tuple of 2 floats or None
        RMS error of the re-simulated position, rad; None if the simulation is not possible with these parameters.
    """

    log: str
    relative_rms: tuple[float, float]
    similarity: tuple[float, float]
    position_rms: tuple[float, float] | None


@dataclass(frozen=True)
class MethodResult:
    """All about one method.

    Attributes
    ----------
    method, title : str
        Its name on the command line, and in words.
    parameters : tuple of Parameter
        The nine.
    claims_intervals : bool
        Whether it gives intervals.
    consistent : bool
        Whether the inertia matrix is positive definite and no friction is negative.
    why_not_consistent : str
        Which condition fails; empty if none does.
    fit : Score
        On the log itself, the samples it was fitted to.
    validation : tuple of Score
        On the logs given with ``--validate``.
    halves : tuple of Score
        Each half predicted from the other; empty for a method too slow for it.
    whiteness : tuple of 2 floats
        Autocorrelation of the residual of each joint at a lag of one period of the cut-off: 0 is white.
    notes : tuple of str
        What the method says about itself: weights, rejected samples, shrinkage chosen ...
    citation : str
        Key of the method's source in the BibTeX file.
    """

    method: str
    title: str
    parameters: tuple[Parameter, ...]
    claims_intervals: bool
    consistent: bool
    why_not_consistent: str
    fit: Score
    validation: tuple[Score, ...]
    halves: tuple[Score, ...]
    whiteness: tuple[float, float]
    notes: tuple[str, ...]
    citation: str


@dataclass(frozen=True)
class Excitation:
    """What the motion can tell at all, whatever the method.

    Attributes
    ----------
    rank : int
        Numerical rank of the regressor with columns of unit length; 9 if all are told apart.
    condition : float
        Its condition number.
    share : tuple of 9 floats
        RMS torque that each parameter moves, over the RMS torque, at the recommended estimate.
    friction_correlation : tuple of 2 floats
        Correlation of the estimates of viscous and Coulomb friction, joint 1 and joint 2.
    unexcited : tuple of str
        Names of parameters the motion does not excite.
    base_parameters : tuple of str
        Combinations that are determined if the rank is below 9, in words such as "I1 + 0.31 I3"; else the names.
    """

    rank: int
    condition: float
    share: tuple[float, ...]
    friction_correlation: tuple[float, float]
    unexcited: tuple[str, ...]
    base_parameters: tuple[str, ...]


@dataclass(frozen=True)
class Preparation:
    """How signals were filtered.

    Attributes
    ----------
    filter : str
        In words.
    cutoff : float
        Cut-off, Hz.
    cutoff_reason : str
        How it was chosen, one line.
    delay : float
        Torque was shifted by this much to fit the motion best, s; positive: the torque acts later than recorded.
    friction_steepness : float
        lambda of Eq. 1, s/rad.
    rate : float
        Rate of the samples that methods see, Hz.
    samples : int
        How many they see.
    cut : float
        Length left out at each end, s.
    """

    filter: str
    cutoff: float
    cutoff_reason: str
    delay: float
    friction_steepness: float
    rate: float
    samples: int
    cut: float


@dataclass(frozen=True)
class Result:
    """Everything the JSON file holds.

    Attributes
    ----------
    arm : str
        Name of the arm.
    simulated : bool
        Whether the log was made by the simulated board.
    log : Description
        Log that was fitted.
    validation_logs : tuple of Description
        Logs that were predicted.
    preparation : Preparation
        Filtering.
    excitation : Excitation
        What the motion can tell.
    methods : tuple of MethodResult
        In the order they were asked for.
    recommended : str
        Name of the method whose parameters to use, and
    reason : str
        why, one line.
    warnings : tuple of str
        About the result as a whole.
    more_logs : tuple of Description
        Logs that were fitted together with `log`.
    setup : tuple of tuple of CalibrationError
        What the set-up gets wrong and was put right before the fit, of `log` and of each of `more_logs`.
    hidden : tuple of dict of str to float or None
        What else it could get wrong unseen, and up to which size, see
        `repro.identification.extra_terms.calibration_limits`, of each log as in `setup`.
    friction : tuple of tuple of FrictionTerm
        Friction beyond Eq. 1 that was taken out of the torque or would help, of each log as in `setup`.
    selftest : SelfTest or None
        What comes out of known parameters, where it was asked for.
    """

    arm: str
    simulated: bool
    log: Description
    validation_logs: tuple[Description, ...]
    preparation: Preparation
    excitation: Excitation
    methods: tuple[MethodResult, ...]
    recommended: str
    reason: str
    warnings: tuple[str, ...] = ()
    more_logs: tuple[Description, ...] = ()
    setup: tuple[tuple[CalibrationError, ...], ...] = ()
    hidden: tuple[dict[str, float | None], ...] = ()
    friction: tuple[tuple[FrictionTerm, ...], ...] = ()
    selftest: SelfTest | None = None


@dataclass(frozen=True)
class Signals:
    """Curves of one log, for the report.

    Attributes
    ----------
    name : str
        File name.
    t : array of shape (n,)
        Time, s.
    tau : array of shape (2, n)
        Filtered torque, N m.
    rebuilt : dict
        For each method its torque, array of shape (2, n), N m.
    frequency : array of shape (m,)
        Hz.
    tau_spectrum : array of shape (2, m)
        Amplitude of the filtered torque, N m.
    rebuilt_spectrum : dict
        For each method an array of shape (2, m), N m.
    """

    name: str
    t: Array
    tau: Array
    rebuilt: dict[str, Array]
    frequency: Array
    tau_spectrum: Array
    rebuilt_spectrum: dict[str, Array]


@dataclass(frozen=True)
class Curves:
    """All curves of a report.

    Attributes
    ----------
    signals : tuple of Signals
        The log first, then the validation logs.
    cutoff : Cutoff or None
        How the cut-off was chosen, if it was.
    """

    signals: tuple[Signals, ...] = field(default_factory=tuple)
    cutoff: Cutoff | None = None
