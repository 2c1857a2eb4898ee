"""One network of the factorial."""

from pathlib import Path

from repro.pipeline.factorial_networks import train_cell
from repro.pipeline.job import job

with job(snakemake.log[0], snakemake.threads):
    train_cell(
        snakemake.wildcards.cell,
        int(snakemake.wildcards.seed),
        Path(snakemake.output[0]),
        snakemake.params.checkpoint,
        snakemake.input.get("motions"),
        snakemake.params.config,
    )
