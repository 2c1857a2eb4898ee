"""The arm's parameters by Algorithm 1 and its refinement, one network and one seed."""

from repro.pipeline.job import job
from repro.pipeline.network_stages import identify_experiment

with job(snakemake.log[0], snakemake.threads):
    identify_experiment(
        snakemake.wildcards.suffix.removeprefix("-") or "published",
        int(snakemake.wildcards.seed),
        snakemake.input.items(),
        snakemake.output[0],
        snakemake.params.config,
    )
