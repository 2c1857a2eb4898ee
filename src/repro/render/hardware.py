"""The hardware blocks of the FPGA and their buses (Fig. 2)."""

import pandas as pd
from matplotlib.figure import Figure

from repro.render import style
from repro.render.diagram import draw_diagram
from repro.render.layout import Box, Layout, Route

LAYOUT = Layout(
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
    return draw_diagram(frame, LAYOUT)
