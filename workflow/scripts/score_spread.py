"""Identification and validation of many specimens for one duration."""

from pathlib import Path

from repro.files import write_csv
from repro.pipeline.job import job
from repro.pipeline.networks import algorithm1_of, for_the_arm
from repro.pipeline.numeric import read_mean_torque
from repro.pipeline.monte_carlo import score_specimens
from repro.settings import of_network, signal_settings

with job(snakemake.log[0], snakemake.threads):
    config = snakemake.params.config
    tau_mean = read_mean_torque(snakemake.input.mean_torque, signal_settings(config))
    networks = [
        for_the_arm(algorithm1_of(name, weights, of_network(config, name), digest), config)
        for weights, (name, digest) in zip(snakemake.input.weights, snakemake.params.trained_as.items(), strict=True)
    ]
    recordings, index = Path(snakemake.input.recordings), int(snakemake.wildcards.index)
    write_csv(snakemake.output[0], score_specimens(networks, recordings, index, tau_mean, config))
