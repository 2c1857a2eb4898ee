"""The arm's parameters by least squares."""

from repro.pipeline.experiment_stages import identify_least_squares
from repro.pipeline.job import job

with job(snakemake.log[0], snakemake.threads):
    identify_least_squares(snakemake.input.items(), snakemake.output[0], snakemake.params.config)
