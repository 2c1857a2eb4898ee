"""One network of the factorial with one seed of guesses on every block."""

from pathlib import Path

from repro.files import write_csv
from repro.pipeline.factorial_networks import score_cell
from repro.pipeline.job import job
from repro.pipeline.numeric import read_mean_torque
from repro.settings import signal_settings

with job(snakemake.log[0], snakemake.threads):
    config = snakemake.params.config
    cell, seed, search = (snakemake.wildcards[name] for name in ("cell", "seed", "search"))
    weights, recordings = Path(snakemake.input.weights), Path(snakemake.input.recordings)
    tau_mean = read_mean_torque(snakemake.input.mean_torque, signal_settings(config))
    write_csv(snakemake.output[0], score_cell(cell, int(seed), int(search), weights, recordings, tau_mean, config))
