"""The report: every table, figure and published number in one page."""

from pathlib import Path

from repro.pipeline.job import job
from repro.report.page import make_report

with job(snakemake.log[0], snakemake.threads):
    make_report(
        snakemake.input.captures,
        str(Path(snakemake.input.templates[0]).parent),
        snakemake.params.overlays,
        snakemake.params.config,
    )
