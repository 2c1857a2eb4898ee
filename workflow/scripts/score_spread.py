"""Identification and validation of many specimens for one duration."""

from repro.pipeline.job import job
from repro.pipeline.network_stages import score_specimens

with job(snakemake.log[0], snakemake.threads):
    score_specimens(
        int(snakemake.wildcards.index), snakemake.input.items(), snakemake.output[0], snakemake.params.config
    )
