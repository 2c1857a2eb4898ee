"""Similarity of the numeric torques and their rebuilding."""

from repro.pipeline.job import job
from repro.pipeline.stages import score_numeric

with job(snakemake.log[0], snakemake.threads):
    score_numeric(list(snakemake.input), snakemake.output[0], snakemake.params.config)
