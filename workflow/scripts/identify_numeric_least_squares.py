"""All numeric arms by least squares, without and with bounds."""

from repro.files import write_json
from repro.pipeline.job import job
from repro.pipeline.numeric import least_squares_of_arms
from repro.settings import numeric_settings, signal_settings

with job(snakemake.log[0], snakemake.threads):
    config = snakemake.params.config
    write_json(snakemake.output[0], least_squares_of_arms(signal_settings(config), numeric_settings(config)))
