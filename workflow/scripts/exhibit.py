"""One table or figure: its numbers, then their layouts or drawing."""

from repro.exhibits.make import make_exhibit
from repro.pipeline.job import job

with job(snakemake.log[0], snakemake.threads):
    make_exhibit(
        snakemake.params.exhibit, snakemake.input.items(), snakemake.output.items(), snakemake.params.config
    )
