"""Similarity of every estimate of the arm on all five motions."""

from repro.files import write_csv
from repro.pipeline.experiment_runs import score_runs
from repro.pipeline.experiment_runs import every_seed, read_identifications
from repro.pipeline.job import job
from repro.pipeline.experiment import read_recordings
from repro.settings import metric_settings, signal_settings

with job(snakemake.log[0], snakemake.threads):
    config = snakemake.params.config
    runs = every_seed(read_identifications(snakemake.input.identifications))
    recordings = read_recordings(snakemake.input.captures, config)
    write_csv(snakemake.output[0], score_runs(runs, recordings, signal_settings(config), metric_settings(config)))
