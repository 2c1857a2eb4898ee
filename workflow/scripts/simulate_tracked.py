"""Motions as arms track Eq. 10, for training."""

from repro.pipeline.job import job
from repro.pipeline.tracked import simulate_tracked

with job(snakemake.log[0], snakemake.threads):
    simulate_tracked(snakemake.params.config, snakemake.output[0])
