"""One network."""

from repro.pipeline.job import job
from repro.pipeline.network_stages import train_network

with job(snakemake.log[0], snakemake.threads):
    train_network(
        snakemake.wildcards.suffix.removeprefix("-") or "published",
        snakemake.input.items(),
        snakemake.output.items(),
        snakemake.params.checkpoint,
        snakemake.params.config,
    )
