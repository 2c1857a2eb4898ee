"""The ledger of every published number."""

from pathlib import Path

from repro.paper.ledger import write_ledger
from repro.pipeline.job import job

with job(snakemake.log[0], snakemake.threads):
    folder = Path(snakemake.output[0]).parent
    write_ledger(folder, snakemake.params.config, [Path(name) for name in snakemake.input])
