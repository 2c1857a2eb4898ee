"""Headline numbers under one reading of the paper."""

from repro.pipeline.ablation import run_variant
from repro.pipeline.job import job

with job(snakemake.log[0], snakemake.threads):
    run_variant(
        snakemake.wildcards.reading,
        snakemake.input.weights,
        list(snakemake.input.captures),
        snakemake.output[0],
        snakemake.params.config,
    )
