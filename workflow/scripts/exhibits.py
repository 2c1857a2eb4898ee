"""Tables and figures made from the same files: their numbers, then their layouts or drawings."""

from repro.exhibits.declare import make_exhibits
from repro.pipeline.job import job

with job(snakemake.log[0], snakemake.threads):
    make_exhibits(
        snakemake.params.exhibits, snakemake.input.items(), snakemake.output.items(), snakemake.params.config
    )
