"""Audit of the paper."""

from repro.pipeline.claims_stage import make_audit
from repro.pipeline.job import job

with job(snakemake.log[0], snakemake.threads):
    make_audit(snakemake.params.name, snakemake.output.items())
