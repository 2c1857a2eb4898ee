"""Words of Figures 1 to 4 and Table 1, each with the place of the paper it is rebuilt from.

The paper's own pictures are lost to us, so nothing here is copied from one: a row is either stated in the text named
beside it, or inferred from it. Sentences are counted within their section. Formulas are in ASCII, between backticks
where they stand among words; ``-`` stands for nothing.
"""

from itertools import pairwise
from pathlib import Path

import pandas as pd

from repro.files import read_csv
from repro.fpga.frames import PWM_LIMIT, SAMPLING_PERIOD
from repro.signals.programs import MEMORY_SAMPLES

DIAGRAM_COLUMNS = ("element", "name", "start", "end", "label", "source", "basis")
ARM_COLUMNS = ("symbol", "mark", "description", "unit", "source", "basis")


def related_work() -> pd.DataFrame:
    """Table 1: the cited works [11] to [28] of Section I-A and the article; what it does not say is ``not stated``."""
    return read_csv(Path(__file__).with_name("related_work.csv")).astype(str)


def arm() -> pd.DataFrame:
    """Figure 1: symbols of the two-link arm."""
    model, table2 = "Section II, Eq. 1", "Section II, Eq. 1 (Table 2)"
    rows = [
        ("x", "axis", "axes of the plane", "m", model, "inferred"),
        ("y", "axis", "axes of the plane", "m", model, "inferred"),
        ("g", "gravity", "gravity", "m/s^2", model, "stated"),
    ]
    for mark, symbol, description, unit, source in (
        ("angle", "q", "joint position", "rad", model),
        ("torque", "tau", "joint torque", "N m", model),
        ("mass", "m", "link mass", "kg", table2),
        ("inertia", "J", "inertia at centre of mass", "kg m^2", table2),
        ("length", "l", "link length", "m", table2),
        ("centre", "lc", "joint to centre of mass", "m", table2),
        ("friction", "b", "viscous friction", "kg m^2/s", table2),
        ("friction", "k", "Coulomb friction", "kg m^2/s^2", table2),
    ):
        for joint in (1, 2):  # Eq. 1 needs no l2, but it is part of a two-link arm
            basis = "inferred" if f"{symbol}{joint}" == "l2" else "stated"
            rows.append((f"{symbol}{joint}", mark, description, unit, source, basis))
    return pd.DataFrame(rows, columns=ARM_COLUMNS)


def _section(section: str, *sentences: int) -> str:
    """Place of one or more sentences."""
    plural = "s" if len(sentences) > 1 else ""
    return f"Section {section}, sentence{plural} {', '.join(str(n) for n in sentences)}"


def _diagram(boxes: list[tuple[str, str, str, str]], links: list[tuple[str, str, str, str, str, str]]) -> pd.DataFrame:
    """Boxes (name, label, source, basis) and links (name, start, end, label, source, basis) in one table."""
    rows = [("box", name, "-", "-", *rest) for name, *rest in boxes]
    rows += [("link", *link) for link in links]
    return pd.DataFrame(rows, columns=DIAGRAM_COLUMNS)


def hardware() -> pd.DataFrame:
    """Figure 2: hardware blocks of the FPGA and the buses between them."""
    rate = f"{1 / SAMPLING_PERIOD:g} Hz"

    def at(*sentences: int) -> tuple[str, str]:
        return _section("III", *sentences), "stated"

    def guessed(*sentences: int) -> tuple[str, str]:
        return _section("III", *sentences), "inferred"

    boxes = [
        ("FPGA", "Cyclone IV EP4CE22F17C6 on a DE0-NANO board, clock 100 MHz,", *at(31, 32)),
        (
            "FPGA",
            f"cycle {1e3 * SAMPLING_PERIOD:g} ms, 6683 of 22320 logic elements (29.94 %), 87 % of the memory",
            *at(5, 30, 31),
        ),
        ("PC", "sends trajectory and gains,", *at(8)),
        ("PC", "receives positions and torques", *at(19)),
        ("Write Ram", "decodes PC data", *at(9)),
        ("Ram-FPGA", "single precision", *at(9)),
        ("Ram-FPGA", f"{MEMORY_SAMPLES} x 2 float32", _section("III", 31) + "; docs/protocol.md", "inferred"),
        ("Read Ram", "gains, PWM frequencies,", *at(11)),
        ("Read Ram", "desired position", *at(12)),
        ("Aq time", rate, *at(12)),
        ("Fp ops", "multiply, add, subtract,", *at(15)),
        ("Fp ops", "integer to float and back", *at(15)),
        ("PD", "error and velocity", *at(17)),
        ("PD", "give the torque;", *at(17)),
        ("PD", "saturation (Fig. 3)", *at(18)),
        ("PWM gen", "tau to pulses", *at(14)),
        ("H bridge", "clock signal", *at(20)),
        ("Decoder", "encoder pulses to position", *at(2, 13)),
        ("Aq uart", "64-bit frame: identifier 8 bit,", *at(21, 22)),
        ("Aq uart", "positions 2 x 16 bit, torques 2 x 11 bit", *at(22, 23)),
        ("Motors", "H bridges,", *at(20)),
        ("Motors", "2 DC motors,", *at(26)),
        ("Motors", "3 N·m at 12 V,", *at(27)),
        ("Motors", "gears 131.25 : 1", *at(26)),
        ("Encoders", "0.748 mrad", *at(28)),
    ]
    links = [
        ("uart in", "PC", "Write Ram", "UART", *at(1, 8)),
        ("uart out", "Aq uart", "PC", "UART", *at(1, 19)),
        ("program", "Write Ram", "Ram-FPGA", "-", *at(9)),
        ("memory", "Ram-FPGA", "Read Ram", "-", *guessed(9, 11)),
        ("time", "Aq time", "Read Ram", "-", *at(12)),
        ("bst", "Write Ram", "PD", "bst", *at(10)),
        ("ctrlv", "Read Ram", "PD", "ctrlv", *at(11, 16)),
        ("tryd", "Read Ram", "PD", "tryd", *at(12)),
        ("operands", "Fp ops", "PD", "-", *guessed(15)),
        ("tau", "PD", "PWM gen", "tau", *at(14, 17)),
        ("pwm", "PWM gen", "Motors", "2 PWM", *at(3, 14)),
        ("clock", "H bridge", "Motors", "clock", *at(20)),
        ("shaft", "Motors", "Encoders", "-", *guessed(26, 28)),
        ("pulses", "Encoders", "Decoder", "pulses", *at(2, 13)),
        ("position", "Decoder", "PD", "32-bit position", *at(13, 16)),
        ("position out", "Decoder", "Aq uart", "-", *at(13, 21)),
        ("torque out", "PD", "Aq uart", "tau", *at(21)),
    ]
    return _diagram(boxes, links)


def control() -> pd.DataFrame:
    """Figure 3: one cycle of the PD control with its saturation."""
    caption = "caption of Fig. 3"
    three = "Section III, sentence"
    checks = f"{three} 18; {caption}"
    boxes = [
        ("Sample i", f"every {1e3 * SAMPLING_PERIOD:g} ms, joints `j = 1`, 2", f"{three}s 5, 12", "stated"),
        ("Read", "`q_j(i)` from Decoder,", f"{three}s 13, 16", "stated"),
        ("Read", "`q_dj(i)`, `K_pj`, `K_vj` from Read Ram", f"{three}s 11, 12, 16", "stated"),
        ("Position error", "`e_j = q_dj(i) - q_j(i)`", f"{three} 17; Eq. 2", "stated"),
        ("Velocity difference", "`v_j = q_j(i) - q_j(i-1)`", f"{three} 17; Eq. 2", "stated"),
        ("Torque", "`tau_j = K_pj e_j - K_vj v_j`", f"{three} 17; Eq. 2", "stated"),
        ("Upper check", "`tau_j > L_j`?", checks, "stated"),
        ("Lower check", "`tau_j < -L_j`?", f"{three}s 18, 25; {caption}", "inferred"),
        ("Upper limit", "`tau_j = L_j`", checks, "stated"),
        ("Lower limit", "`tau_j = -L_j`", f"{three}s 18, 25; {caption}", "inferred"),
        ("Limits", f"`L_1 = L_2 = {PWM_LIMIT}`", caption, "stated"),
        ("Limits", "PWM counts", f"{three} 25", "stated"),
        ("Output", "`tau_j` to PWM gen;", f"{three} 14", "stated"),
        ("Output", "`q_j(i)`, `tau_j` to Aq uart", f"{three}s 19, 21", "stated"),
        ("Keep", "`q_j(i)` as the next `q_j(i-1)`", "Eq. 2", "inferred"),
    ]
    links = [
        (f"{start} - {end}", start, end, label, source, basis)
        for start, end, label, source, basis in (
            ("Sample i", "Read", "-", f"{three}s 5, 12", "inferred"),
            ("Read", "Position error", "-", f"{three}s 16, 17", "stated"),
            ("Read", "Velocity difference", "-", f"{three}s 16, 17", "stated"),
            ("Position error", "Torque", "-", f"{three} 17", "stated"),
            ("Velocity difference", "Torque", "-", f"{three} 17", "stated"),
            ("Torque", "Upper check", "-", f"{three} 18", "stated"),
            ("Upper check", "Upper limit", "yes", checks, "stated"),
            ("Upper check", "Lower check", "no", f"{three} 18", "inferred"),
            ("Lower check", "Lower limit", "yes", f"{three}s 18, 25; {caption}", "inferred"),
            ("Upper limit", "Output", "-", f"{three}s 14, 18", "stated"),
            ("Lower limit", "Output", "-", f"{three}s 14, 18", "inferred"),
            ("Lower check", "Output", "no", f"{three}s 14, 18", "inferred"),
            ("Output", "Keep", "-", "Eq. 2", "inferred"),
            ("Keep", "Sample i", "-", f"{three} 12", "inferred"),
        )
    ]
    return _diagram(boxes, links)


def method() -> pd.DataFrame:
    """Figure 4: the identification method with its nine steps."""

    def at(*sentences: int, also: str = "") -> tuple[str, str]:
        return _section("IV", *sentences) + also, "stated"

    boxes = [
        ("Robot arm", "PD control on the", *at(2)),
        ("Robot arm", "predefined trajectory", *at(2)),
        ("Signals", "`q`, velocity, acceleration", *at(3)),
        ("Signals", "and torque `tau`", *at(3)),
        ("1 Initialise", "guess `beta_n`", *at(9)),
        ("2 Image", "of signals and `beta_n`", *at(3, 9)),
        ("3 CNN", "reads the image", *at(4, 9)),
        ("4 Residual", "`r`, 0 if `beta_n` fits", *at(4, 9)),
        ("5 Parameters", "`beta = beta_n + r`", *at(5, 9, also="; Algorithm 1, line 21")),
        ("6 Torque", "`tau_r` from Eq. 1 with `beta`", *at(6, 9)),
        ("7 Similarity", "of `tau` and `tau_r`", *at(7, 9)),
        ("8 Decision", "above `u`?", *at(8, 9)),
        ("9 Adjustment", "`beta` to the level of `tau`", *at(8, 9)),
        ("Result", "parameters `beta_o`", "Algorithm 1, line 32", "stated"),
    ]
    steps = [name for name, *_ in boxes if name[0].isdigit()]
    # Each step hands on what the next one needs.
    links = [
        (f"{start[0]} - {end[0]}", start, end, "yes" if start[0] == "8" else "-", *at(9))
        for start, end in pairwise(steps)
    ]
    again = "Algorithm 1, lines 16, 17"
    links += [
        ("signals", "Robot arm", "Signals", "-", *at(3)),
        ("to 2", "Signals", "2 Image", "-", *at(3)),
        ("to 6", "Signals", "6 Torque", "motion", *at(6)),
        ("to 7", "Signals", "7 Similarity", "`tau`", *at(7)),
        ("to 9", "Signals", "9 Adjustment", "`tau`", *at(8)),
        ("guess", "1 Initialise", "5 Parameters", "`beta_n`", *at(5)),
        ("again", "8 Decision", "1 Initialise", "no: new guess", again, "stated"),
        ("result", "9 Adjustment", "Result", "-", "Algorithm 1, line 32", "stated"),
    ]
    return _diagram(boxes, links)
