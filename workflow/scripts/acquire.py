"""The capture of one motion: stored, simulated or from a serial port."""

from repro.pipeline.experiment_stages import acquire_capture
from repro.pipeline.job import job

with job(snakemake.log[0], snakemake.threads):
    acquire_capture(snakemake.wildcards.motion, list(snakemake.output), snakemake.params.config)
