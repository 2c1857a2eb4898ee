"""Least squares and true parameters on the factorial's blocks."""

from pathlib import Path

from repro.files import write_csv
from repro.pipeline.factorial import score_references
from repro.pipeline.job import job

with job(snakemake.log[0], snakemake.threads):
    write_csv(snakemake.output[0], score_references(Path(snakemake.input[0]), snakemake.params.config))
