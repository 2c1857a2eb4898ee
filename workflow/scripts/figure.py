"""One figure: its numbers, then the drawing."""

from repro.pipeline.job import job
from repro.pipeline.stages import make_figure

with job(snakemake.log[0], snakemake.threads):
    make_figure(snakemake.params.name, snakemake.input.items(), snakemake.output.items(), snakemake.params.config)
