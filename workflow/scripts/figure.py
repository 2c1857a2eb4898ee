"""One figure: its numbers, then the drawing."""

from repro.pipeline.figure_stage import make_figure
from repro.pipeline.job import job

with job(snakemake.log[0], snakemake.threads):
    make_figure(snakemake.params.name, snakemake.input.items(), snakemake.output.items(), snakemake.params.config)
