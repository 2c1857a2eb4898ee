"""The arm's parameters by Algorithm 1 and its refinement, one network and every seed."""

from repro.files import write_json
from repro.pipeline.experiment import true_parameters
from repro.pipeline.experiment_runs import identify_recording
from repro.pipeline.job import job
from repro.pipeline.networks import algorithm1_of, for_the_arm
from repro.pipeline.numeric import read_mean_torque
from repro.pipeline.experiment import read_recordings
from repro.settings import signal_settings

with job(snakemake.log[0], snakemake.threads):
    config, variant = snakemake.params.config, snakemake.wildcards.suffix.removeprefix("-") or "published"
    signals, true = signal_settings(config), true_parameters(config)
    tau_mean = read_mean_torque(snakemake.input.mean_torque, signals)
    (recording,) = read_recordings(snakemake.input.captures, config)
    algorithm1 = for_the_arm(algorithm1_of(variant, snakemake.input.weights, config, snakemake.params.trained_as), config)
    for seed, output in zip(snakemake.params.seeds, snakemake.output, strict=True):
        write_json(output, identify_recording(algorithm1, recording, tau_mean, signals, seed, true))
