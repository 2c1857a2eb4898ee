"""What the paper describes without numbers of ours: Tables 1 and 2, Figures 1 to 4 and 18."""

import pandas as pd

from repro.exhibits.declare import ARM, EXPERIMENT, METHOD, MODEL, Inputs, figure, table
from repro.pipeline import experiment_data, schematics_data
from repro.pipeline.description import parameter_description
from repro.pipeline.experiment import control_constants, program_settings
from repro.pipeline.job import Config
from repro.render import description_tables, experiment_setup, flow_charts, two_link_arm


@table(1, "Related work", METHOD, description_tables.related_work)
def table01(_: Inputs, __: Config) -> pd.DataFrame:
    """Related work and this article, rebuilt from Section I-A (the paper's Table 1 is an image): robot, degrees of
    freedom, method, what is identified, and whether the text says that an optimised trajectory is needed.
    """
    return schematics_data.related_work()


@table(2, "Dynamic parameters", MODEL, description_tables.parameters)
def table02(_: Inputs, __: Config) -> pd.DataFrame:
    """The nine dynamic parameters, rebuilt from Eq. 1 (the paper's Table 2 is an image)."""
    return parameter_description()


@figure(1, "Schematic of the arm", METHOD, two_link_arm.schematic)
def fig01(_: Inputs, __: Config) -> pd.DataFrame:
    """Schematic of the two-link arm with the symbols of Eq. 1. The paper's own picture (Fig. 1) is not available to us:
    redrawn from Section II and Eq. 1. The pose is arbitrary; q = 0 hangs straight down and q2 is measured from link 1.
    """
    return schematics_data.arm()


@figure(2, "Hardware blocks of the FPGA", METHOD, flow_charts.hardware)
def fig02(_: Inputs, __: Config) -> pd.DataFrame:
    """Hardware blocks of the FPGA and the buses between them. The paper's own picture (Fig. 2) is not available to us:
    redrawn from the text of Section III; the data say for each block and bus which sentence states it. Dotted links and
    words in italics are inferred: that Read Ram reads Ram-FPGA, that the PD uses Fp ops, that the encoders sit on the
    motors, and the memory's size.
    """
    return schematics_data.hardware()


@figure(3, "Flow chart of the PD control", METHOD, flow_charts.control)
def fig03(_: Inputs, __: Config) -> pd.DataFrame:
    """Flow chart of one cycle of the PD control with its saturation. The paper's own picture (Fig. 3) is not available
    to us: redrawn from Section III, Eq. 2 and its caption, L1 = L2 = 1023. Dotted arrows and words in italics are
    inferred; L1 and L2 are read as the limits of joints 1 and 2 in both directions.
    """
    return schematics_data.control()


@figure(4, "Identification method", METHOD, flow_charts.method)
def fig04(_: Inputs, __: Config) -> pd.DataFrame:
    """General diagram of the identification method with its nine steps. The paper's own picture (Fig. 4) is not
    available to us: redrawn from Section IV; the way back from the decision to a new guess is that of Algorithm 1.
    """
    return schematics_data.method()


@figure(18, "Experimental set-up", EXPERIMENT, experiment_setup.setup, sections=ARM)
def fig18(_: Inputs, config: Config) -> pd.DataFrame:
    """The simulated experimental set-up: the real acquisition program, the serial device it opens, the simulated FPGA
    board with its blocks, the simulated motors, and the two-link arm (Fig. 18 of the paper is a photograph of the real
    one).
    """
    settings = program_settings(config)
    return experiment_data.setup_figure(control_constants(config), settings.geometry, settings.h)
