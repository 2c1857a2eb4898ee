"""Verification of the ledger."""

from repro.pipeline.claims_stage import verify_claims
from repro.pipeline.job import job

with job(snakemake.log[0], snakemake.threads):
    verify_claims(snakemake.output[0], snakemake.params.config)
