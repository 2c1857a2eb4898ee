"""Similarity of every estimate of the numeric arms, on the identification and the validation trajectories."""

from repro.files import write_csv
from repro.pipeline.experiment_runs import every_seed, read_identifications
from repro.pipeline.job import job
from repro.pipeline.numeric import score_estimates
from repro.settings import metric_settings, numeric_settings, signal_settings

with job(snakemake.log[0], snakemake.threads):
    config = snakemake.params.config
    runs = every_seed(read_identifications(list(snakemake.input)))
    scores = score_estimates(runs, signal_settings(config), numeric_settings(config), metric_settings(config))
    write_csv(snakemake.output[0], scores)
