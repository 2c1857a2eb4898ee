"""Search of the formula of metr2ev."""

from repro.pipeline.job import job
from repro.pipeline.metric_stage import search_metric_formula

with job(snakemake.log[0], snakemake.threads):
    search_metric_formula(snakemake.output.items(), snakemake.params.config)
