"""One network, trained or taken from those that come with the project."""

from repro.pipeline.job import job
from repro.pipeline.networks import train_network

with job(snakemake.log[0], snakemake.threads):
    train_network(
        snakemake.wildcards.suffix.removeprefix("-") or "published",
        dict(snakemake.output.items()),
        snakemake.params.checkpoint,
        snakemake.params.config,
        snakemake.input.get("motions"),
    )
