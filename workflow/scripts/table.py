"""One table: its numbers, then the layouts."""

from repro.pipeline.job import job
from repro.pipeline.table_stage import make_table

with job(snakemake.log[0], snakemake.threads):
    make_table(snakemake.params.name, snakemake.input.items(), snakemake.output.items(), snakemake.params.config)
