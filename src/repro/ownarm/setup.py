"""What the set-up gets wrong, in words and as lines of the arm file."""

from collections.abc import Sequence

import numpy as np

from repro.identification.extra_terms import MIN_Z_SCORE, CalibrationError, FrictionTerm
from repro.logs.armfile import Arm
from repro.ownarm.prepared import Ready
from repro.ownarm.result import Result

#: What is said where one line of an arm file cannot be right for all logs.
APART = (
    "the logs differ in what is wrong with them: one arm file cannot put them all right. A zero may have been set anew "
    "before a log, or one of the logs tells too little"
)
#: A fault in words, by its name without the joint.
KINDS = {"zero": "zero", "offset": "offset of the torque", "scale": "scale of the torque"}


def arm_lines(faults: Sequence[CalibrationError], arm: Arm) -> tuple[str, ...]:
    """Lines of the arm file that put a log right, all faults together."""
    found = {fault.name: fault.value for fault in faults}
    sign, torque_sign = np.array(arm.sign), np.array(arm.sign) * np.array(arm.torque_sign)
    turn = np.array([found.get("zero1", 0.0), found.get("zero2", 0.0)])
    if arm.second_joint_absolute:  # what is added to joint 1 is taken from joint 2 afterwards
        turn[1] += turn[0]
    offset = np.array([found.get("offset1", 0.0), found.get("offset2", 0.0)])
    values = {
        "zero": np.array(arm.zero) - sign * turn,
        "torque_offset": np.array(arm.torque_offset) + torque_sign * offset * np.array(arm.torque_scale),
        "torque_scale": np.array(arm.torque_scale) * [1.0, found.get("scale2", 1.0)],
    }
    wanted = {"zero": "zero", "offset": "torque_offset", "scale": "torque_scale"}
    keys = [key for kind, key in wanted.items() if any(name.startswith(kind) for name in found)]
    return tuple(f"{key}: [{values[key][0]:.4g}, {values[key][1]:.4g}]" for key in keys)


def told(logs: Sequence[Ready], arm: Arm) -> tuple[str, ...]:
    """What is wrong with each log; which log it is where there are several."""
    lines = [
        f"in {log.told.description.name} {line}" if len(logs) > 1 else line
        for log in logs
        for line in (*words(log.faults, arm), *(friction(term) for term in log.terms if not term.taken))
    ]
    return (*lines, *([] if all(_alike(log.faults, logs[0].faults) for log in logs) else [APART]))


def _alike(some: Sequence[CalibrationError], others: Sequence[CalibrationError]) -> bool:
    """Whether two logs have the same faults, of sizes within what both are sure of."""
    pairs = list(zip(some, others, strict=False))
    same = [a.name for a in some] == [b.name for b in others]
    return same and all(abs(a.value - b.value) <= MIN_Z_SCORE * np.hypot(a.error, b.error) for a, b in pairs)


def friction(term: FrictionTerm) -> str:
    """A row of its own for friction beyond Eq. 1."""
    what = {"load": "of its load", "stribeck": "N m more at rest"}[term.name[:-1]]
    size = f"friction beyond Eq. 1 of joint {term.name[-1]}: {term.value:.3g} +- {2 * term.error:.2g} {what}"
    done = "takes" if term.taken else "left out, would take"
    return f"{size}; {done} {100 * term.gain:.0f} % of the squared error of parts not fitted"


def words(faults: Sequence[CalibrationError], arm: Arm) -> tuple[str, ...]:
    """One line for each fault, and one with what to write into the arm file."""
    lines = []
    for fault in faults:
        joint, size = fault.name[-1], _size(fault.name, fault.value, fault.error)
        what = {
            "zero": f"the zero of joint {joint} is {size} off",
            "offset": f"the torque of joint {joint} has an offset of {size}",
            "scale": f"the torque of joint {joint} is {size} what joint 1 says: one of the torque constants is wrong",
        }[fault.name[:-1]]
        what += _instead(fault)
        lines.append(
            f"{what}; with it the torque error falls from {_percent(fault.before)} to {_percent(fault.after)} %"
        )
    if lines:
        lines.append(f"this is put right here; for good, write into the arm file: {'; '.join(arm_lines(faults, arm))}")
    return tuple(lines)


def not_shown(result: Result) -> tuple[str, ...]:
    """What the set-up could get wrong without its showing, a line for each log that was fitted."""
    lines = []
    for log, hidden in zip((result.log, *result.more_logs), result.hidden, strict=False):
        parts = []
        for name, size in hidden.items():
            parts.append(f"{KINDS[name[:-1]]} of joint {name[-1]} {_up_to(name[:-1], size)}")
        if parts:
            where = f"{log.name} would" if result.more_logs else "this log would"
            lines.append(f"what {where} not show of a wrong set-up: {', '.join(parts)}")
    return tuple(lines)


def _up_to(kind: str, size: float | None) -> str:
    if size is None:
        return "of any size"
    units = {"zero": f"{_degrees(size)} degrees", "offset": f"{size:.2g} N m", "scale": f"{100.0 * size:.0f} %"}
    return f"up to {units[kind]}"


def _instead(fault: CalibrationError) -> str:
    if not fault.instead:
        return ""
    others = (f"the {KINDS[name[:-1]]} of joint {name[-1]}: {_size(name, x)}" for name, x in fault.instead.items())
    return f" (this log can hardly tell it from {', or '.join(others)})"


def _size(name: str, value: float, error: float | None = None) -> str:
    """Value, two standard errors either way where one is given, and unit; a zero as it stands in the arm file."""
    unit, turn, digits = {
        "zero": ("degrees", float(-np.degrees(1.0)), 2),
        "offset": ("N m", 1.0, 3),
        "scale": ("times", 1.0, 3),
    }[name[:-1]]
    spread = "" if error is None else f" +- {2 * error * abs(turn):.2g}"
    return f"{value * turn:.{digits}g}{spread} {unit}"


def _degrees(radians: float) -> str:
    return f"{np.degrees(radians):.2g}"


def _percent(share: float) -> str:
    return f"{100.0 * share:.1f}"
