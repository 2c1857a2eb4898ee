"""Identification and validation of many specimens for one duration."""

from pathlib import Path

from repro.files import write_csv
from repro.pipeline.job import job
from repro.pipeline.methods import for_the_arm, identifier_of
from repro.pipeline.numeric import read_mean_torque
from repro.pipeline.specimens import score_specimens
from repro.settings import of_network, signal_settings

with job(snakemake.log[0], snakemake.threads):
    config = snakemake.params.config
    tau_mean = read_mean_torque(snakemake.input.mean_torque, signal_settings(config))
    identifiers = [
        for_the_arm(identifier_of(name, weights, of_network(config, name)), config)
        for name, weights in zip(("published", "tracked"), snakemake.input.weights, strict=True)
    ]
    recordings, index = Path(snakemake.input.recordings), int(snakemake.wildcards.index)
    write_csv(snakemake.output[0], score_specimens(identifiers, recordings, index, tau_mean, config))
