"""Hardware blocks of the FPGA (Fig. 2), flow chart of the PD control (Fig. 3) and diagram of the method (Fig. 4)."""

import pandas as pd
from matplotlib.figure import Figure

from repro.exhibits import style
from repro.render.diagram import draw_diagram
from repro.render.layout import Box, Layout, Route

HARDWARE = Layout(
    width=style.PAGE,
    height=3.52,
    boxes={
        "FPGA": Box(1.26, 0.33, 4.61, 3.13, "frame"),
        "PC": Box(0.05, 0.43, 0.76, 2.47, "outside"),
        "Write Ram": Box(1.36, 2.28, 0.92, 0.62),
        "Ram-FPGA": Box(2.50, 2.28, 0.92, 0.62),
        "Read Ram": Box(3.62, 2.28, 1.10, 0.62),
        "Aq time": Box(4.98, 2.28, 0.82, 0.62),
        "Fp ops": Box(1.98, 1.28, 1.32, 0.54),
        "PD": Box(3.62, 1.25, 1.10, 0.62),
        "PWM gen": Box(4.98, 1.49, 0.82, 0.38),
        "H bridge": Box(4.98, 1.00, 0.82, 0.38),
        "Decoder": Box(4.98, 0.43, 0.82, 0.46),
        "Aq uart": Box(1.36, 0.43, 2.08, 0.50),
        "Motors": Box(6.29, 1.08, 0.82, 0.79, "outside"),
        "Encoders": Box(6.29, 0.43, 0.82, 0.46, "outside"),
    },
    routes={
        "uart in": Route("PC", "Write Ram", ((0.81, 2.59), (1.36, 2.59)), (1.035, 2.66), flow="downlink"),
        "uart out": Route("Aq uart", "PC", ((1.36, 0.68), (0.81, 0.68)), (1.035, 0.75), flow="uplink"),
        "program": Route("Write Ram", "Ram-FPGA", ((2.28, 2.59), (2.50, 2.59))),
        "memory": Route("Ram-FPGA", "Read Ram", ((3.42, 2.59), (3.62, 2.59))),
        "time": Route("Aq time", "Read Ram", ((4.98, 2.59), (4.72, 2.59))),
        "bst": Route("Write Ram", "PD", ((1.60, 2.28), (1.60, 2.04), (3.76, 2.04), (3.76, 1.87)), (1.68, 2.11), "left"),
        "ctrlv": Route("Read Ram", "PD", ((4.12, 2.28), (4.12, 1.87)), (4.09, 2.11), "right"),
        "tryd": Route("Read Ram", "PD", ((4.50, 2.28), (4.50, 1.87)), (4.47, 2.11), "right"),
        "operands": Route("Fp ops", "PD", ((3.30, 1.55), (3.62, 1.55)), both=True),
        "tau": Route("PD", "PWM gen", ((4.72, 1.68), (4.98, 1.68)), (4.85, 1.76)),
        "pwm": Route("PWM gen", "Motors", ((5.80, 1.68), (6.29, 1.68)), (6.08, 1.75)),
        "clock": Route("H bridge", "Motors", ((5.80, 1.19), (6.29, 1.19)), (6.08, 1.26)),
        "shaft": Route("Motors", "Encoders", ((6.70, 1.08), (6.70, 0.89))),
        "pulses": Route("Encoders", "Decoder", ((6.29, 0.66), (5.80, 0.66)), (6.08, 0.73)),
        "position": Route("Decoder", "PD", ((4.98, 0.60), (4.17, 0.60), (4.17, 1.25)), (4.21, 1.06), "left"),
        "position out": Route("Decoder", "Aq uart", ((4.98, 0.60), (3.44, 0.60))),
        "torque out": Route("PD", "Aq uart", ((3.80, 1.25), (3.80, 0.80), (3.44, 0.80)), (3.84, 1.06), "left"),
    },
    type_size=style.SMALL_SIZE,
    junctions=((4.17, 0.60),),
    legend=(
        ("downlink", "From the PC"),
        ("uplink", "To the PC"),
        ("inner", "Stated in Section III"),
        ("inferred", "Inferred from it"),
        ("block", "In the FPGA"),
        ("outside", "Outside"),
    ),
    columns=6,
)


def hardware(frame: pd.DataFrame) -> Figure:
    """Hardware blocks of the FPGA with their buses (Fig. 2)."""
    return draw_diagram(frame, HARDWARE)


CONTROL = Layout(
    width=style.COLUMN,
    height=5.40,
    boxes={
        "Sample i": Box(0.37, 4.93, 1.90, 0.42, "end"),
        "Read": Box(0.22, 4.23, 2.20, 0.52, "step"),
        "Position error": Box(0.22, 3.65, 1.25, 0.40, "step"),
        "Velocity difference": Box(1.60, 3.65, 1.35, 0.40, "step"),
        "Torque": Box(0.47, 3.07, 1.70, 0.40, "step"),
        "Upper check": Box(0.47, 2.31, 1.70, 0.58, "decision"),
        "Lower check": Box(0.47, 1.55, 1.70, 0.58, "decision"),
        "Limits": Box(2.42, 2.91, 0.98, 0.54, "outside"),
        "Upper limit": Box(2.50, 2.40, 0.78, 0.40, "step"),
        "Lower limit": Box(2.50, 1.64, 0.78, 0.40, "step"),
        "Output": Box(0.37, 0.85, 1.90, 0.52, "step"),
        "Keep": Box(0.37, 0.27, 1.90, 0.40, "step"),
    },
    routes={
        f"{route.start} - {route.end}": route
        for route in (
            Route("Sample i", "Read", ((1.32, 4.93), (1.32, 4.75))),
            Route("Read", "Position error", ((0.80, 4.23), (0.80, 4.05))),
            Route("Read", "Velocity difference", ((1.90, 4.23), (1.90, 4.05))),
            Route("Position error", "Torque", ((0.80, 3.65), (0.80, 3.47))),
            Route("Velocity difference", "Torque", ((1.90, 3.65), (1.90, 3.47))),
            Route("Torque", "Upper check", ((1.32, 3.07), (1.32, 2.89))),
            Route("Upper check", "Lower check", ((1.32, 2.31), (1.32, 2.13)), (1.37, 2.23), "left"),
            Route("Upper check", "Upper limit", ((2.17, 2.60), (2.50, 2.60)), (2.31, 2.68)),
            Route("Lower check", "Lower limit", ((2.17, 1.84), (2.50, 1.84)), (2.31, 1.92)),
            Route("Lower check", "Output", ((1.32, 1.55), (1.32, 1.37)), (1.37, 1.47), "left"),
            Route("Upper limit", "Output", ((3.28, 2.60), (3.40, 2.60), (3.40, 1.03), (2.27, 1.03))),
            Route("Lower limit", "Output", ((2.89, 1.64), (2.89, 1.19), (2.27, 1.19))),
            Route("Output", "Keep", ((1.32, 0.85), (1.32, 0.67))),
            Route("Keep", "Sample i", ((0.37, 0.47), (0.10, 0.47), (0.10, 5.14), (0.37, 5.14))),
        )
    },
    legend=(("inner", "Stated in the text"), ("inferred", "Inferred from it")),
)

METHOD = Layout(
    width=style.PAGE,
    height=2.92,
    boxes={
        "Robot arm": Box(0.08, 2.34, 1.13, 0.52, "outside"),
        "Signals": Box(1.41, 2.34, 1.65, 0.52, "outside"),
        "1 Initialise": Box(0.08, 1.55, 1.13, 0.54, "step"),
        "2 Image": Box(1.41, 1.55, 1.13, 0.54, "step"),
        "3 CNN": Box(2.74, 1.55, 1.13, 0.54, "step"),
        "4 Residual": Box(4.07, 1.55, 1.13, 0.54, "step"),
        "5 Parameters": Box(5.40, 1.55, 1.13, 0.54, "step"),
        "6 Torque": Box(5.40, 0.37, 1.13, 0.54, "step"),
        "7 Similarity": Box(4.07, 0.37, 1.13, 0.54, "step"),
        "8 Decision": Box(2.72, 0.33, 1.17, 0.62, "decision"),
        "9 Adjustment": Box(1.41, 0.37, 1.13, 0.54, "step"),
        "Result": Box(0.08, 0.41, 1.13, 0.46, "end"),
    },
    routes={
        "1 - 2": Route("1 Initialise", "2 Image", ((1.21, 1.82), (1.41, 1.82))),
        "2 - 3": Route("2 Image", "3 CNN", ((2.54, 1.82), (2.74, 1.82))),
        "3 - 4": Route("3 CNN", "4 Residual", ((3.87, 1.82), (4.07, 1.82))),
        "4 - 5": Route("4 Residual", "5 Parameters", ((5.20, 1.82), (5.40, 1.82))),
        "5 - 6": Route("5 Parameters", "6 Torque", ((5.965, 1.55), (5.965, 0.91))),
        "6 - 7": Route("6 Torque", "7 Similarity", ((5.40, 0.64), (5.20, 0.64))),
        "7 - 8": Route("7 Similarity", "8 Decision", ((4.07, 0.64), (3.89, 0.64))),
        "8 - 9": Route("8 Decision", "9 Adjustment", ((2.72, 0.64), (2.54, 0.64)), (2.64, 0.72)),
        "signals": Route("Robot arm", "Signals", ((1.21, 2.60), (1.41, 2.60))),
        "to 2": Route("Signals", "2 Image", ((1.975, 2.34), (1.975, 2.09))),
        "to 6": Route("Signals", "6 Torque", ((3.06, 2.60), (7.0, 2.60), (7.0, 0.64), (6.53, 0.64)), (6.76, 0.72)),
        "to 7": Route(
            "Signals",
            "7 Similarity",
            ((3.06, 2.60), (7.0, 2.60), (7.0, 0.14), (4.635, 0.14), (4.635, 0.37)),
            (4.70, 0.25),
            "left",
        ),
        "to 9": Route(
            "Signals",
            "9 Adjustment",
            ((3.06, 2.60), (7.0, 2.60), (7.0, 0.14), (1.975, 0.14), (1.975, 0.37)),
            (2.04, 0.25),
            "left",
        ),
        "guess": Route(
            "1 Initialise",
            "5 Parameters",
            ((0.95, 1.55), (0.95, 1.36), (5.65, 1.36), (5.65, 1.55)),
            (3.305, 1.44),
        ),
        "again": Route(
            "8 Decision",
            "1 Initialise",
            ((3.305, 0.95), (3.305, 1.12), (0.34, 1.12), (0.34, 1.55)),
            (1.975, 1.20),
        ),
        "result": Route("9 Adjustment", "Result", ((1.41, 0.64), (1.21, 0.64))),
    },
    junctions=((7.0, 0.64), (4.635, 0.14)),
)


def control(frame: pd.DataFrame) -> Figure:
    """Flow chart of one cycle of the PD control with its saturation (Fig. 3)."""
    return draw_diagram(frame, CONTROL)


def method(frame: pd.DataFrame) -> Figure:
    """General diagram of the identification method (Fig. 4)."""
    return draw_diagram(frame, METHOD)
