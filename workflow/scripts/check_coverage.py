"""Whether the intervals of the network of tracked motions cover."""

from pathlib import Path

from repro.files import write_csv
from repro.pipeline.coverage import coverage
from repro.pipeline.job import job
from repro.pipeline.methods import for_the_arm, identifier_of
from repro.pipeline.numeric import read_mean_torque
from repro.pipeline.recordings import read_recordings
from repro.settings import signal_settings

with job(snakemake.log[0], snakemake.threads):
    config = snakemake.params.config
    tau_mean = read_mean_torque(snakemake.input.mean_torque, signal_settings(config))
    (recording,) = read_recordings(snakemake.input.captures, config)
    identifier = for_the_arm(identifier_of("tracked", snakemake.input.weights, config), config)
    tables = coverage(identifier, Path(snakemake.input.motions), recording, tau_mean, config)
    for name, output in snakemake.output.items():
        write_csv(output, tables[name])
