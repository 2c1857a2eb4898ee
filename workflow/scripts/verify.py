"""Verification of the ledger, and of its promises if the configuration enforces them."""

from pathlib import Path

from repro.files import write_text
from repro.paper.ledger import verified
from repro.pipeline.job import job

with job(snakemake.log[0], snakemake.threads):
    write_text(snakemake.output[0], verified(Path(snakemake.output[0]).parent, snakemake.params.config))
