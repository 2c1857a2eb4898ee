"""The arm's parameters by least squares, plain and with constraints."""

from repro.files import write_json
from repro.pipeline.experiment import true_parameters
from repro.pipeline.experiment_runs import least_squares_of
from repro.pipeline.job import job
from repro.pipeline.experiment import read_recordings
from repro.settings import signal_settings

with job(snakemake.log[0], snakemake.threads):
    config = snakemake.params.config
    (recording,) = read_recordings(snakemake.input.captures, config)
    write_json(snakemake.output[0], least_squares_of(recording, signal_settings(config), true_parameters(config)))
