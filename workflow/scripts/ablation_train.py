"""The network of one reading of the paper."""

from repro.pipeline.ablation import train_variant
from repro.pipeline.job import job

with job(snakemake.log[0], snakemake.threads):
    train_variant(
        snakemake.wildcards.trained,
        snakemake.output.weights,
        snakemake.output.history,
        snakemake.input.tracked,
        snakemake.params.checkpoint,
        snakemake.params.config,
    )
