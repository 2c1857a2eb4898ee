"""Whether the intervals of the network of tracked motions cover."""

from pathlib import Path

from repro.files import write_csv
from repro.pipeline.coverage import coverage
from repro.pipeline.job import job
from repro.pipeline.networks import algorithm1_of, for_the_arm
from repro.pipeline.numeric import read_mean_torque
from repro.pipeline.experiment import read_recordings
from repro.settings import signal_settings

with job(snakemake.log[0], snakemake.threads):
    config = snakemake.params.config
    tau_mean = read_mean_torque(snakemake.input.mean_torque, signal_settings(config))
    (recording,) = read_recordings(snakemake.input.captures, config)
    algorithm1 = for_the_arm(algorithm1_of("tracked", snakemake.input.weights, config, snakemake.params.trained_as), config)
    tables = coverage(algorithm1, Path(snakemake.input.motions), recording, tau_mean, config)
    for name, output in snakemake.output.items():
        write_csv(output, tables[name])
