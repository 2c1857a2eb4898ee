"""Recordings of many specimens of the arm."""

from repro.pipeline.experiment_stages import simulate_specimens
from repro.pipeline.job import job

with job(snakemake.log[0], snakemake.threads):
    simulate_specimens(snakemake.output[0], snakemake.params.config)
