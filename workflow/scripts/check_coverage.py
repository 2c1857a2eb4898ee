"""Whether the intervals of the network of tracked motions cover."""

from repro.pipeline.job import job
from repro.pipeline.network_stages import check_coverage

with job(snakemake.log[0], snakemake.threads):
    check_coverage(snakemake.input.items(), snakemake.output.items(), snakemake.params.config)
