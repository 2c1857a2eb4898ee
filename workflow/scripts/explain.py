"""The search of one network on every step from the ideal case to the recording."""

from repro.files import write_csv
from repro.pipeline.job import job
from repro.pipeline.networks import algorithm1_of, for_the_arm
from repro.pipeline.numeric import read_mean_torque
from repro.pipeline.why import explain
from repro.settings import signal_settings

with job(snakemake.log[0], snakemake.threads):
    config, variant = snakemake.params.config, snakemake.wildcards.suffix.removeprefix("-") or "published"
    tau_mean = read_mean_torque(snakemake.input.mean_torque, signal_settings(config))
    algorithm1 = for_the_arm(algorithm1_of(variant, snakemake.input.weights, config, snakemake.params.trained_as), config)
    write_csv(snakemake.output[0], explain(algorithm1, tau_mean, config["why"]["seeds"], config))
