"""Sentences of `repro identify`: verdicts, calibration errors, friction, and the summary on the screen."""

import math
from collections.abc import Sequence

import numpy as np

from repro.errors import option
from repro.fitting.prepare import PreparedLog
from repro.fitting.result import Parameter, Result, Score, SelfTest
from repro.identification.armfile import Arm
from repro.identification.calibration import CALIBRATION, OTHER_SCALE, SCALE, CalibrationError, blame_joint_1
from repro.identification.extra_terms import (
    LOAD,
    MIN_Z_SCORE,
    ROTOR,
    STRIBECK,
    UNMODELLED_EFFECTS,
    ExtraTerm,
    values_of,
)
from repro.identification.filtering import MIN_ERROR_REDUCTION
from repro.logs.conventions import READS_BETTER
from repro.model.parameters import NAMES, SIGNED, Array, has_possible_signs

#: What the intervals allow for: by groups, and in full.
ALLOWED_GROUPS = (
    "the 95 % intervals allow for noise, errors of the motion, the choice of filters, lambda and delay, and one "
    "unmodelled effect at a time: calibration, friction, torque ripple, motor, gear; not for several large ones, nor "
    "for a wrong scale of both torques: validate on other motions"
)
ALLOWED = (
    "the 95 % intervals allow for noise, the choice of filters, lambda and delay, errors of the motion, "
    f"{', '.join(UNMODELLED_EFFECTS)}, "
    "one of these effects at a time; not for a wrong scale of both torques"
)
MAX_KNOWN_SHARE = 0.5  # half an interval over the estimate, up to which the parameter is known
NOTHING = "\N{EN DASH}"  # cell without a number
YES_OR_NO = {None: NOTHING, True: "yes", False: "no"}
NOT_EXCITED = "not excited by this motion"
FIXED = "not estimated: given as known"
IMPOSSIBLE = "negative, which no arm has: something is wrong with the log or the model"
COMBINED = "determined in a combination only, see the base parameters"
AT_BOUND = "held at zero: the log alone would give it an impossible sign"
NO_INTERVAL = "the method claims no interval"
NOT_FROM_ZERO = "cannot be distinguished from zero"
SIGN_KNOWN = "sign known, size only roughly"
#: Warning where no single arm file is right for all logs.
DIFFERENT_ERRORS = (
    "the logs have different calibration errors: no single arm file corrects them all. Either a zero was set again "
    "between the logs, or one of the logs shows too little"
)
#: Calibration errors by their names without the joint.
CALIBRATION_LABELS = {"zero": "zero", "offset": "offset of the torque", "scale": "scale of the torque"}


def known_to(percent: str) -> str:
    """Give the verdict on a parameter with a narrow interval."""
    return f"known to {percent} %"


def verdict(
    estimate: float,
    low: float | None,
    high: float | None,
    excited: bool,  # whether it moves a considerable part of a torque
    at_bound: bool,  # whether a condition of the method keeps it at zero
    determined: bool = True,  # whether the motion determines it by itself
    possible: bool = True,  # whether an arm can have such a value
    doubt: str = "",  # why there is no interval; empty where the method claims none
) -> str:
    """Summarise an estimate and its 95 % interval in one phrase."""
    if not determined:
        return COMBINED if excited else NOT_EXCITED
    if at_bound:
        return AT_BOUND
    if low is None or high is None:
        none = f"no interval: {doubt}" if doubt else NO_INTERVAL
        return none if excited else NOT_EXCITED
    if low <= 0.0 <= high:
        return NOT_FROM_ZERO if excited else NOT_EXCITED
    share = 0.5 * (high - low) / abs(estimate)
    known = known_to(_round_up(share)) if share <= MAX_KNOWN_SHARE else SIGN_KNOWN
    return known if possible else IMPOSSIBLE


def by_verdict(parameters: Sequence[Parameter]) -> dict[str, list[str]]:
    """Group the names of parameters by their verdicts, those that are known first."""
    groups: dict[str, list[str]] = {"known": []}
    for p in parameters:
        known = p.verdict.startswith("known to")
        groups.setdefault("known" if known else p.verdict, []).append(p.name)
    return {verdict: names for verdict, names in groups.items() if names}


def _round_up(share: float) -> str:
    """Give percent rounded up to one or two digits: 0.4, 3, 12."""
    percent = 100.0 * share
    rounded = math.ceil(percent - 1e-9) if percent >= 1.0 else max(math.ceil(percent * 10.0 - 1e-9) / 10.0, 0.1)
    return f"{rounded:g}"


def inconsistency(beta: Array) -> str:
    """Name the conditions of physical consistency that fail (inertia, friction, signs), with numbers."""
    i1, i2, i3 = beta[:3]
    found, least = i3 * (i1 - i3), 0.25 * i2**2
    failing = [f"{NAMES[k]} = {beta[k]:.3g} is negative" for k in range(5, 9) if beta[k] < 0]
    if i3 <= 0.0 or found <= least:
        numbers = f"I3 (I1 - I3) = {found:.3g} is not above I2^2 / 4 = {least:.3g}"
        failing.insert(0, f"the inertia matrix is not positive definite: {numbers}")
    if not has_possible_signs(beta):
        product = f"I2 g1 g2 = {beta[[*SIGNED]].prod():.3g} is negative"
        failing.append(f"{product}, which needs a counterweight that outweighs both links about joint 1")
    return "; ".join(failing)


def calibration_warnings(logs: Sequence[PreparedLog], arm: Arm, scale_open: bool) -> tuple[str, ...]:
    """Report calibration errors, with the name of the log if there are several, and terms that were not subtracted."""
    lines = []
    for log in logs:
        where = f"in {log.loaded.name} " if len(logs) > 1 else ""
        misread = any(line.startswith(READS_BETTER) for line in log.loaded.description.warnings)
        lines += [f"{where}{line}" for line in calibration_lines(log.calibration_errors, arm, scale_open, misread)]
    if not all(_same_errors(log.calibration_errors, logs[0].calibration_errors) for log in logs):
        lines.append(DIFFERENT_ERRORS)
    return (*lines, *(term_line(term) for term in logs[0].terms if not term.taken))


def _same_errors(first: Sequence[CalibrationError], second: Sequence[CalibrationError]) -> bool:
    """Whether two logs have the same calibration errors within their uncertainty."""
    pairs = list(zip(first, second, strict=False))
    same_names = [a.name for a in first] == [b.name for b in second]
    return same_names and all(abs(a.value - b.value) <= MIN_Z_SCORE * np.hypot(a.error, b.error) for a, b in pairs)


def calibration_lines(
    errors: Sequence[CalibrationError], arm: Arm, scale_open: bool, misread: bool = False
) -> tuple[str, ...]:
    """Report each calibration error of a log, then the lines to write into the arm file.

    If the scale is open, the torque constant of joint 1 may be wrong instead of that of joint 2. The errors of a log
    that reads better with another convention are not to be corrected before it is tried.
    """
    lines = []
    for error in errors:
        joint, size = error.name[-1], _size(error.name, error.value, arm, error.error)
        problem = {
            "zero": f"the zero of joint {joint} is {size} off",
            "offset": f"the torque of joint {joint} has an offset of {size}",
            "scale": f"the torque of joint {joint} is {size} what joint {3 - int(joint)} implies",
        }[error.kind]
        if error.instead:
            rivals = (f"the {_label(name)}: {_size(name, value, arm)}" for name, value in error.instead.items())
            problem += f" (this log can hardly distinguish it from {', or '.join(rivals)})"
        before, after = 100.0 * error.before, 100.0 * error.after
        lines.append(f"{problem}; the correction reduces the torque error from {before:.1f} to {after:.1f} %")
    if lines and misread:
        remedy = "try the other convention first: it may leave no error"
        return (*lines, f"this fit corrects it as the log is read now; {remedy}")
    if lines:
        lines.append(f"this fit corrects it; to correct it for good, write into the arm file: {arm_lines(errors, arm)}")
    if scale_open and any(error.name == SCALE for error in errors):
        instead = arm_lines([error for error in blame_joint_1(errors) if error.name == OTHER_SCALE], arm)
        lines.append(
            "a log cannot determine which torque constant is wrong: the estimates are right if it is that of joint 2; "
            f"if it is that of joint 1, write {instead} instead; a known parameter decides: {option('prior', 'FILE')}"
        )
    return tuple(lines)


def arm_lines(errors: Sequence[CalibrationError], arm: Arm) -> str:
    """Write the lines of the arm file that correct a log, all errors together."""
    values = values_of(errors)
    turn, offset, scale = (
        np.array([values.get(f"{name}{joint}", kind.neutral) for joint in (1, 2)]) for name, kind in CALIBRATION.items()
    )
    if arm.second_joint_absolute:  # what is added to joint 1 is subtracted from joint 2 afterwards
        turn[1] += turn[0]
    sign, torque_sign = np.array(arm.sign), np.array(arm.sign) * np.array(arm.torque_sign)
    corrected = {
        "zero": np.array(arm.zero) - sign * turn,
        "torque_offset": np.array(arm.torque_offset) + torque_sign * offset * np.array(arm.torque_scale),
        "torque_scale": np.array(arm.torque_scale) * scale,
    }
    kinds = {error.kind for error in errors}
    lines = zip(CALIBRATION, corrected.items(), strict=True)
    return "; ".join(f"{key}: [{pair[0]:.4g}, {pair[1]:.4g}]" for kind, (key, pair) in lines if kind in kinds)


def _label(name: str) -> str:
    """Name a calibration error with its joint."""
    return f"{CALIBRATION_LABELS[name[:-1]]} of joint {name[-1]}"


def _size(name: str, value: float, arm: Arm, error: float | None = None) -> str:
    """Give value as in the arm file, which has its own signs, twice its standard error if known, and unit."""
    k = int(name[-1]) - 1
    unit, factor, digits = {
        "zero": ("degrees", -np.degrees(arm.sign[k]), 2),
        "offset": ("N m", arm.sign[k] * arm.torque_sign[k] * arm.torque_scale[k], 3),
        "scale": ("times", 1.0, 3),
    }[name[:-1]]
    interval = "" if error is None else f" +- {2 * error * abs(factor):.2g}"
    return _with_unit(f"{value * factor:.{digits}g}{interval}", unit)


def _with_unit(size: str, unit: str) -> str:
    """Append a unit, degrees in the singular after 1."""
    return f"{size} {unit.removesuffix('s') if size in ('1', '-1') else unit}"


def term_line(term: ExtraTerm, stribeck_speed: float | None = None) -> str:
    """Report a term that Eq. 1 does not contain."""
    kind, joint = term.kind, term.name[-1]
    steep = "; a Coulomb friction steeper than lambda looks alike (arm file: friction_steepness: auto)"
    at_rest = "N m more at rest" + (f", 1/e of it at {stribeck_speed:.2g} rad/s" if stribeck_speed else "")
    what = {LOAD: "of its load", STRIBECK: at_rest, ROTOR: "kg m^2, next to I3"}[kind]
    of = "inertia of the rotor" if kind == ROTOR else "friction beyond Eq. 1"
    size = f"{of} of joint {joint}: {term.value:.3g} +- {2 * term.error:.2g} {what}"
    done = "it is subtracted, which reduces" if term.taken else "it is not subtracted; that would reduce"
    remedy = steep if term.taken and kind == STRIBECK else ""
    if not term.taken and kind == ROTOR:
        remedy = "; the intervals allow for it"
    elif not term.taken and term.gain >= MIN_ERROR_REDUCTION:
        remedy = ": leave --no-friction (Python: friction=False) out"
    return f"{size}; {done} the cross-validated squared error by {100 * term.gain:.0f} %{remedy}"


#: What an export leaves out, by the kind of term.
NAMES_OF_TERMS = {LOAD: "the load-dependent friction", STRIBECK: "the Stribeck friction", ROTOR: "the rotor"}


def export_lines(result: Result) -> tuple[str, ...]:
    """Report the torque error of each export that cannot contain a term of the arm."""
    lines: dict[str, list[str]] = {}  # the exports that a line is about
    for name, scores in result.exports.items():
        errors = ", ".join(_errors("", score) for score in scores)
        left_out = ", ".join(f"{NAMES_OF_TERMS[x[:-1]]} of joint {x[-1]}" for x in result.left_out_of(name))
        lines.setdefault(f"{left_out}: torque error {errors} %", []).append(name)
    return tuple(f"{' and '.join(names)} omit{'s' * (len(names) == 1)} {line}" for line, names in lines.items())


def detection_limits(result: Result) -> tuple[str, ...]:
    """Report which calibration errors each fitted log could contain undetected."""
    lines = []
    for log, limits in zip(result.fitted_logs, result.calibration_limits, strict=False):
        if limits:
            which = log.name if result.more_logs else "this log"
            errors = (f"{_label(name)} {_limit(name[:-1], limit)}" for name, limit in limits.items())
            lines.append(f"{which} could contain these calibration errors undetected: {', '.join(errors)}")
    return tuple(lines)


def _limit(kind: str, size: float | None) -> str:
    if size is None:
        return "of any size"
    factor, unit = {"zero": (float(np.degrees(1.0)), "degrees"), "offset": (1.0, "N m"), "scale": (100.0, "%")}[kind]
    digits = float(f"{factor * size:.2g}")  # as a number, it is written without an exponent
    return f"up to {_with_unit(f'{digits:g}', unit)}"


def spread_rows(result: Result) -> list[tuple[str, ...]]:
    """Print a heading and a row for each parameter: together, each log alone, range, whether the intervals agree."""
    if not result.spread:
        return []
    rows: list[tuple[str, ...]] = [("", "together", *map(str, range(1, len(result.runs) + 1)), "range", "agree")]
    for row in result.spread:
        numbers = [f"{x:.4g}" for x in (row.together, *row.estimates, row.range)]
        rows.append((f"{row.name}, {row.unit}", *numbers, YES_OR_NO[row.agree]))
    return rows


def self_test_rows(test: SelfTest) -> list[tuple[str, ...]]:
    """Print the self-test: parameter, true value, median, range, coverage."""
    rows: list[tuple[str, ...]] = []
    for p in test.parameters:
        coverage = f"{p.hold} of {p.intervals}" if p.intervals else "none claimed"
        rows.append((p.name, f"{p.true:.4g}", f"{p.median:.4g}", f"{p.low:.4g} to {p.high:.4g}", coverage))
    return rows


def self_test_verdict(test: SelfTest) -> str:
    """Compare the errors of the synthetic logs with that of the log."""
    right, here = ("/".join(f"{100.0 * x:.1f}" for x in pair) for pair in (test.error, test.real))
    errors = f"if Eq. 1 were right, the torque error of joint 1/2 would be {right} %; it is {here} %"
    if not test.model_wrong:
        return f"{errors}: noise explains it, and there is no sign that Eq. 1 is wrong"
    noise = "/".join(f"{100.0 * x:.0f}" for x in test.noise)
    rest = "The model causes the rest: friction, flexibility or calibration errors"
    return f"{errors}: noise explains {noise} % of its square. {rest}"


def summary(result: Result) -> str:
    """Give what to know without opening the report."""
    best = result.best
    lines = [f"{result.arm}{' (simulated)' if result.simulated else ''}: {best.title}, {result.reason}"]
    lines += [f"  {p.name} = {p.estimate:.4g} {p.unit}: {p.verdict}" for p in best.parameters]
    if best.claims_intervals:
        lines.append(f"  {ALLOWED_GROUPS} (in full: report.html)")
    speed = result.preparation.stribeck_speed
    lines += [f"  {term_line(term, speed)}" for term in result.terms if term.taken]
    lines += [f"  {line}" for line in export_lines(result)]
    lines += [f"  {line}" for line in detection_limits(result)]
    lines.append("torque error, relative RMS of joint 1 / joint 2 in % (re-simulated position in windows of 0.5 s):")
    for m in result.methods:
        errors = ", ".join(_errors(part, score) for part, score in m.scores)
        mark = "*" if m is best else " "
        lines.append(f" {mark}{m.method}{'' if m.consistent else ' (not physically consistent)'}: {errors}")
    if rows := spread_rows(result):
        logs = ", ".join(f"{k} = {run.log}" for k, run in enumerate(result.runs, 1))
        lines.append(f"each log alone by {best.method} ({logs}):")
        lines += ["  " + "".join((f"{row[0]:<15}", *(f"{cell:>12}" for cell in row[1:]))) for row in rows]
    if result.changes:
        lines.append("earlier result, this one, and whether both intervals explain the difference:")
        lines += [
            f"  {c.name:<4}{c.before:>12.4g}{c.now:>12.4g} {c.unit:<12} {YES_OR_NO[c.agree]}" for c in result.changes
        ]
    if test := result.selftest:
        lines.append(f"self-test: {test.draws} synthetic logs of this motion with the parameters of {test.method}")
        heads = ("", "true", "median", "range", "in the interval")
        lines += ["  {:4}{:>11}{:>14}{:>26}{:>22}".format(*row) for row in (heads, *self_test_rows(test))]
        lines.append(self_test_verdict(test))
    lines += [f"WARNING: {warning}" for warning in result.all_warnings]
    return "\n".join(lines)


def _errors(part: str, score: Score) -> str:
    """Give a score's name, the torque error of both joints, and that of the re-simulated position if there is one."""
    name = {"fit": "fit", "log": f"{score.log} from the others"}.get(part, score.log)
    torque = "/".join(f"{100 * error:.1f}" for error in score.relative_rms)
    position = "" if score.position_rms is None else " ({:.2g}/{:.2g} rad)".format(*score.position_rms)
    return f"{name} {torque}{position}"
