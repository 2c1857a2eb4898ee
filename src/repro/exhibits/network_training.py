"""The network and its training: Table 3, Figures 7 to 11."""

import pandas as pd

from repro.cnn.architecture import read_weights
from repro.cnn.schedule import HISTORY_COLUMNS
from repro.exhibits.declare import DATA, MODEL, Inputs, figure, table
from repro.files import read_csv
from repro.pipeline import figure_data
from repro.pipeline.description import architecture, network_features
from repro.pipeline.job import Config
from repro.render import description_tables, images, lines, network
from repro.settings import data_settings, network_settings, signal_settings, training_settings

#: Sections of the configuration that the training data depend on.
_TRAINING = ("signals", "data", "image", "training")


@table(
    3,
    "Characteristics of the network",
    MODEL,
    description_tables.characteristics,
    sections=("signals", "network", "training"),
)
def table03(_: Inputs, config: Config) -> pd.DataFrame:
    """Features of the CNN and its training, rebuilt from Section IV-B (the paper's Table 3 is an image)."""
    return network_features(network_settings(config), training_settings(config))


@figure(7, "Architecture of the CNN", MODEL, network.network, sections=("signals", "network"))
def fig07(_: Inputs, config: Config) -> pd.DataFrame:
    """Architecture of the CNN with every size (Fig. 7). The widths of layers 4 and 5 are not in the paper's text; ours
    are in the configuration.
    """
    return architecture(network_settings(config))


@figure(8, "Images of the training data", DATA, images.examples, sections=_TRAINING)
def fig08(_: Inputs, config: Config) -> pd.DataFrame:
    """Signal images whose guess is right (M_p) and wrong (M_n), in the colours of Eq. 16, clipped to the displayable
    range (Fig. 8). Images with the same letter share their torque.
    """
    return figure_data.example_images(signal_settings(config), data_settings(config), training_settings(config).seed)


@figure(9, "Distribution of the training torques", DATA, lines.torque_distribution, sections=_TRAINING)
def fig09(_: Inputs, config: Config) -> pd.DataFrame:
    """Distribution of 10,000 training torques, each divided by its largest magnitude (Fig. 9)."""
    return figure_data.torque_distribution(
        signal_settings(config), data_settings(config), training_settings(config).seed
    )


@figure(10, "Loss over the training", MODEL, lines.loss, inputs=("history",), trained="all")
def fig10(inputs: Inputs, _: Config) -> pd.DataFrame:
    """Training and held-out loss of the streamed recipe (Fig. 10)."""
    return figure_data.loss(read_csv(inputs["history"][0], HISTORY_COLUMNS))


@figure(
    11,
    "Spectra of the kernels",
    MODEL,
    images.kernels,
    inputs=("weights",),
    sections=("signals", "network"),
    trained="all",
)
def fig11(inputs: Inputs, config: Config) -> pd.DataFrame:
    """Power spectra of the convolution kernels after training, each normalised to its largest value, zero frequency in
    the middle (Fig. 11).
    """
    return figure_data.kernel_spectra(read_weights(inputs["weights"][0], network_settings(config)))
