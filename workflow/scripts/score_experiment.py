"""Similarity of every estimate of the arm on all five motions."""

from repro.pipeline.experiment_stages import score_experiment
from repro.pipeline.job import job

with job(snakemake.log[0], snakemake.threads):
    score_experiment(snakemake.input.items(), snakemake.output[0], snakemake.params.config)
