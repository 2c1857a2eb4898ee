"""Mean torque of the training data."""

from repro.pipeline.job import job
from repro.pipeline.stages import mean_torque

with job(snakemake.log[0], snakemake.threads):
    mean_torque(snakemake.output[0], snakemake.params.config)
