"""All numeric arms for one network and every seed."""

from repro.files import write_json
from repro.pipeline.job import job
from repro.pipeline.networks import algorithm1_of
from repro.pipeline.numeric import identify_arms, read_mean_torque
from repro.settings import numeric_settings, signal_settings

with job(snakemake.log[0], snakemake.threads):
    config, variant = snakemake.params.config, snakemake.wildcards.suffix.removeprefix("-") or "published"
    signals, numeric = signal_settings(config), numeric_settings(config)
    tau_mean = read_mean_torque(snakemake.input.mean_torque, signals)
    algorithm1 = algorithm1_of(variant, snakemake.input.weights, config, snakemake.params.trained_as)
    for seed, output in zip(snakemake.params.seeds, snakemake.output, strict=True):
        write_json(output, identify_arms(algorithm1, signals, numeric, tau_mean, seed))
