"""Design a motion for identifying your own arm, within its limits."""

import argparse
import logging
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from repro.commands.options import folder, integer, number, options_named, seconds, seed
from repro.errors import InputError

if TYPE_CHECKING:
    from repro.identification.exciting_motion import Envelope
    from repro.model.parameters import Array
    from repro.signals.trajectories import Motion


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of ``repro excite``."""
    add = parser.add_argument
    parser.epilog = "Example: repro excite --arm arm.yaml -o OUT. Guide: docs/own-arm.md."
    add("--arm", metavar="FILE", required=True, type=Path, help="arm.yaml with position_limit and speed_limit")
    add("-o", "--out", metavar="FOLDER", required=True, type=folder, help="folder for the motion and its accuracy")
    add("--overwrite", action="store_true", help="replace files of the same names in that folder")
    add(
        "--guess",
        metavar="FILE",
        nargs="+",
        help="parameters.json of repro identify, or nine numbers: then torque_limit is kept, too",
    )
    add("--duration", metavar="SECONDS", type=seconds, default=20.0, help="of the motion, s (default: 20)")
    add(
        "--harmonics",
        metavar="COUNT",
        type=integer(1, 1000),
        default=12,
        help="highest multiple of 1/duration in it (default: 12)",
    )
    add(
        "--rate",
        metavar="HZ",
        type=number(1.0, 1e5, "a rate in Hz"),
        default=400.0,
        help="samples per second (default: 400, the board's)",
    )
    add(
        "--noise",
        nargs=2,
        type=number(1e-9, 1e6, "a number"),
        default=(0.05, 0.05),
        metavar=("TAU1", "TAU2"),
        help="standard deviation of a sample of each torque, N m (default: 0.05 0.05)",
    )
    add("--seed", metavar="INTEGER", type=seed, default=1, help="of the starts of the search (default: 1)")


def run(arguments: argparse.Namespace) -> int:
    """Design a motion for identifying your own arm, within its limits."""
    import numpy as np

    from repro.files import check_folder, fill_folder
    from repro.identification.armfile import read_arm
    from repro.identification.exciting_motion import Envelope, check_samples, excite, published

    logging.getLogger("fontTools").setLevel(logging.WARNING)  # it reports every glyph
    check_folder(arguments.out, arguments.overwrite)
    harmonics, noise, h = arguments.harmonics, np.array(arguments.noise), 1.0 / arguments.rate
    with options_named("duration", "rate", "rate times duration", "harmonics"):
        steps = check_samples(arguments.duration, arguments.rate, harmonics)
    arm, guess = read_arm(arguments.arm), read_guess(arguments.guess)
    if arm.plane != "vertical":
        raise InputError.at(f"{arguments.arm}: plane", arm.plane, "vertical, for which the motion is designed")
    limits = Envelope(arm, guess)
    asked = {key: getattr(arguments, key) for key in ("harmonics", "rate", "noise", "seed")}
    ours = excite(arm, guess=guess, duration=arguments.duration, **asked)
    motions = {"optimised": ours, "eq10": published(limits, (steps, h), harmonics / (steps * h), noise)}
    content = {
        "settings": {**asked, "duration": steps * h, "guess": None if guess is None else guess.tolist()},
        "arm": {**asdict(arm), "file": arguments.arm.name},
        **{name: summarise_motion(motion, limits, noise) for name, motion in motions.items()},
    }
    if not np.isfinite(content["optimised"]["condition"]):
        found = "limits of position, speed or torque that let no motion separate the parameters"
        raise InputError.at(f"{arguments.arm}: position_limit, speed_limit, torque_limit", found, "wider ones")
    given = [Path(name) for name in (arguments.arm, *(arguments.guess or [])) if name]
    files = fill_folder(arguments.out, lambda folder: _write_files(folder, content, ours, limits), inputs=given)
    print(summary(content))
    print(f"written to {arguments.out}: {', '.join(files)}")
    return 0


def read_guess(given: list[str] | None) -> "Array | None":
    """Read the parameters of ``--guess``."""
    from repro.documents import read_json
    from repro.fitting.prior import read_result
    from repro.identification.exciting_motion import check_guess

    if given is None:
        return None
    numbers: list[Any] = given
    if len(given) == 1:  # the estimates of the recommended method
        path = Path(given[0])
        numbers = [parameter["estimate"] for parameter in read_result(str(path), read_json(path))]
    with options_named("guess"):
        return check_guess(numbers)


def summarise_motion(motion: "Motion", limits: "Envelope", noise: "Array") -> dict[str, Any]:
    """Give the extremes of a motion and the expected half-widths of its intervals."""
    import numpy as np

    from repro.identification.exciting_motion import expected_accuracy
    from repro.model.dynamics import inverse_dynamics
    from repro.model.parameters import NAMES

    moved = motion.q, motion.dq, motion.ddq
    torque = None if limits.beta is None else inverse_dynamics(*moved, limits.beta, limits.steepness)
    peaks = {"speed_rad_s": motion.dq, "acceleration_rad_s2": motion.ddq, "torque_nm": torque}
    half, condition, log_det = expected_accuracy(moved, noise, limits.steepness)
    return {
        "position_rad": np.stack([motion.q.min(axis=1), motion.q.max(axis=1)], axis=1).tolist(),
        **{key: None if x is None else np.abs(x).max(axis=1).tolist() for key, x in peaks.items()},
        "condition": condition,
        "log_det": log_det,
        "half_widths": dict(zip(NAMES, half.tolist(), strict=True)),
    }


def _write_files(folder: Path, content: dict[str, Any], motion: "Motion", limits: "Envelope") -> None:
    import numpy as np
    import pandas as pd

    from repro.drawing import panels, style
    from repro.files import finite, write_csv, write_json

    arm, series, columns = limits.arm, [], {"time_s": motion.time}
    own = np.array([[1.0, 0.0], [float(arm.second_joint_absolute), 1.0]]) * np.array(arm.sign)[:, None]
    zeros = (np.array(arm.zero), np.zeros(2), np.zeros(2))
    names = ("q{}_rad", "dq{}_rad/s", "ddq{}_rad/s^2")
    for panel, name, zero, x in zip(panels.MOTION, names, zeros, (motion.q, motion.dq, motion.ddq), strict=True):
        for j, joint in enumerate(panels.JOINTS):
            columns[name.format(j + 1)] = own[j] @ x + zero[j]
            series.append(pd.DataFrame({"panel": panel, "series": joint, "x": motion.time, "y": x[j]}))
    write_json(folder / "excite.json", finite(content))  # Eq. 10 may not separate the parameters
    write_csv(folder / "motion.csv", pd.DataFrame(columns))
    with style.house_style():
        style.save(panels.draw_motion(pd.concat(series)), arm.name, folder / "motion.pdf", folder / "motion.png")


def summary(content: dict[str, Any]) -> str:
    """Compare the extremes and the expected accuracy with those of Eq. 10's motion."""
    from repro.model.parameters import UNITS

    ours, theirs = content["optimised"], content["eq10"]
    duration, harmonics, rate = (content["settings"][key] for key in ("duration", "harmonics", "rate"))
    lines = [f"{content['arm']['name']}: {duration:g} s, {harmonics} harmonics of {1.0 / duration:.4g} Hz"]
    for j, (low, high) in enumerate(ours["position_rad"]):
        torque = "not limited without --guess" if ours["torque_nm"] is None else f"up to {ours['torque_nm'][j]:.3g} N m"
        lines.append(
            f"  joint {j + 1}: {low:.3g} to {high:.3g} rad, up to {ours['speed_rad_s'][j]:.3g} rad/s and "
            f"{ours['acceleration_rad_s2'][j]:.3g} rad/s^2; torque {torque}"
        )
    noise = " and ".join(f"{sigma:g}" for sigma in content["settings"]["noise"])
    lines.append(f"lower bound of 95 % intervals, +- (Eq. 1 exact, white noise of {noise} N m, {rate:g} samples/s):")
    lines.append(f"  {'':<16}{'this motion':>12}{'Eq. 10':>12}{'ratio':>8}")
    half = zip(ours["half_widths"].items(), theirs["half_widths"].values(), UNITS, strict=True)
    rows = [(f"{name}, {unit}", a, b) for (name, a), b, unit in half]
    for name, a, b in (*rows, ("condition number", ours["condition"], theirs["condition"])):
        lines.append(f"  {name:<16}{a:>12.3g}{b:>12.3g}{a / b:>8.2f}")
    lines.append(
        f"(Eq. 10 at its best pace and amplitude: the same limits and duration, up to {harmonics / duration:.3g} Hz)"
    )
    return "\n".join(lines)
