"""All numeric arms for one network and every seed."""

from repro.pipeline.job import job
from repro.pipeline.network_stages import identify_numeric

with job(snakemake.log[0], snakemake.threads):
    identify_numeric(
        snakemake.wildcards.suffix.removeprefix("-") or "published",
        snakemake.params.seeds,
        snakemake.input.items(),
        list(snakemake.output),
        snakemake.params.config,
    )
