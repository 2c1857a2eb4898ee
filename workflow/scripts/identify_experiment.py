"""The arm's parameters by Algorithm 1 and its refinement, one network and one seed."""

from repro.pipeline.experiment_stages import identify_experiment
from repro.pipeline.job import job

with job(snakemake.log[0], snakemake.threads):
    identify_experiment(
        snakemake.wildcards.suffix.removeprefix("-") or "published",
        int(snakemake.wildcards.seed),
        snakemake.input.items(),
        snakemake.output[0],
        snakemake.params.config,
    )
