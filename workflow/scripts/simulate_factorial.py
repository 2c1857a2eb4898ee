"""Recordings of the factorial's blocks."""

from pathlib import Path

from repro.pipeline.factorial import simulate_blocks
from repro.pipeline.job import job

with job(snakemake.log[0], snakemake.threads):
    simulate_blocks(snakemake.params.config, Path(snakemake.output[0]))
