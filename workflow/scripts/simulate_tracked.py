"""Motions as arms track Eq. 10, for training."""

from pathlib import Path

from repro.pipeline.job import job
from repro.pipeline.tracked import simulate_tracked

with job(snakemake.log[0], snakemake.threads):
    simulate_tracked(snakemake.params.config, Path(snakemake.output[0]))
