"""The arm's parameters by Algorithm 1 and its refinement, one network and every seed."""

from repro.files import write_json
from repro.pipeline.experiment import true_parameters
from repro.pipeline.experiment_runs import identify_recording
from repro.pipeline.job import job
from repro.pipeline.methods import for_the_arm, identifier_of
from repro.pipeline.numeric import read_mean_torque
from repro.pipeline.recordings import read_recordings
from repro.settings import signal_settings

with job(snakemake.log[0], snakemake.threads):
    config, variant = snakemake.params.config, snakemake.wildcards.suffix.removeprefix("-") or "published"
    signals, true = signal_settings(config), true_parameters(config)
    tau_mean = read_mean_torque(snakemake.input.mean_torque, signals)
    (recording,) = read_recordings(snakemake.input.captures, config)
    identifier = for_the_arm(identifier_of(variant, snakemake.input.weights, config), config)
    for seed, output in zip(snakemake.params.seeds, snakemake.output, strict=True):
        write_json(output, identify_recording(identifier, recording, tau_mean, signals, seed, true))
