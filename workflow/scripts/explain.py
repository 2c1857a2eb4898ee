"""The search of one network on every step from the ideal case to the recording."""

from repro.pipeline.job import job
from repro.pipeline.network_stages import explain_network

with job(snakemake.log[0], snakemake.threads):
    explain_network(
        snakemake.wildcards.suffix.removeprefix("-") or "published",
        snakemake.input.items(),
        snakemake.output[0],
        snakemake.params.config,
    )
