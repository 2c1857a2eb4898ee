"""The capture of one motion: stored, simulated or from a serial port."""

from pathlib import Path

from repro.pipeline.experiment import acquire
from repro.pipeline.job import job

with job(snakemake.log[0], snakemake.threads):
    acquire(snakemake.wildcards.motion, Path(snakemake.output[0]), snakemake.params.config)
