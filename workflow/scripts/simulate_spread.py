"""Recordings of many specimens of the arm."""

from pathlib import Path

from repro.pipeline.job import job
from repro.pipeline.monte_carlo import simulate_spread

with job(snakemake.log[0], snakemake.threads):
    simulate_spread(snakemake.params.config, Path(snakemake.output[0]))
