"""The report: every table, figure and published number in one page."""

from repro.pipeline.job import job
from repro.report.page import make_report

with job(snakemake.log[0], snakemake.threads):
    make_report(
        snakemake.input.captures,
        snakemake.input.captions[0],
        snakemake.params.overlays,
        snakemake.params.config,
    )
