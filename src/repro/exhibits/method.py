"""The method and its network: Tables 1 to 3, Figures 1 to 11."""

from repro.cnn.architecture import read_weights
from repro.cnn.schedule import HISTORY_COLUMNS
from repro.exhibits.inputs import Family, Made
from repro.files import read_csv
from repro.pipeline import figure_data as data
from repro.pipeline import schematics_data as schematic
from repro.pipeline.description import architecture, network_features, parameter_description
from repro.render import (
    description_tables,
    flow_charts,
    images,
    lines,
    network,
    two_link_arm,
)
from repro.settings import data_settings, network_settings, numeric_settings, signal_settings, training_settings
from repro.signals.trajectories import identification_trajectory

MADE: Family = {
    ("table", "table01"): Made(lambda _, __: schematic.related_work(), description_tables.related_work),
    ("table", "table02"): Made(lambda _, __: parameter_description(), description_tables.parameters),
    ("table", "table03"): Made(
        lambda _, c: network_features(network_settings(c), training_settings(c)), description_tables.characteristics
    ),
    ("figure", "fig01"): Made(lambda _, __: schematic.arm(), two_link_arm.schematic),
    ("figure", "fig02"): Made(lambda _, __: schematic.hardware(), flow_charts.hardware),
    ("figure", "fig03"): Made(lambda _, __: schematic.control(), flow_charts.control),
    ("figure", "fig04"): Made(lambda _, __: schematic.method(), flow_charts.method),
    ("figure", "fig05"): Made(
        lambda _, c: data.subsampling(signal_settings(c), numeric_settings(c).arms["N1"]), lines.subsampling
    ),
    ("figure", "fig06"): Made(
        lambda _, c: data.trajectory(identification_trajectory(signal_settings(c).duration, signal_settings(c).h)),
        lines.motion,
    ),
    ("figure", "fig07"): Made(lambda _, c: architecture(network_settings(c)), network.network),
    ("figure", "fig08"): Made(
        lambda _, c: data.example_images(signal_settings(c), data_settings(c), training_settings(c).seed),
        images.examples,
    ),
    ("figure", "fig09"): Made(
        lambda _, c: data.torque_distribution(signal_settings(c), data_settings(c), training_settings(c).seed),
        lines.torque_distribution,
    ),
    ("figure", "fig10"): Made(lambda i, _: data.loss(read_csv(i["history"][0], HISTORY_COLUMNS)), lines.loss),
    ("figure", "fig11"): Made(
        lambda i, c: data.kernel_spectra(read_weights(i["weights"][0], network_settings(c))), images.kernels
    ),
}
