"""The ledger of every published number."""

from repro.pipeline.claims_stage import make_claims
from repro.pipeline.job import job

with job(snakemake.log[0], snakemake.threads):
    make_claims(snakemake.output[0], snakemake.input.items(), snakemake.params.config)
