"""Mean training torque, which fit2trt needs."""

import pandas as pd

from repro.files import write_csv
from repro.pipeline.job import job
from repro.pipeline.numeric import mean_training_torque
from repro.settings import data_settings, signal_settings, training_settings
from repro.signals.trajectories import identification_trajectory

with job(snakemake.log[0], snakemake.threads):
    config = snakemake.params.config
    signals = signal_settings(config)
    tau = mean_training_torque(signals, data_settings(config), training_settings(config).seed)
    time = identification_trajectory(signals.duration, signals.h).time
    write_csv(snakemake.output[0], pd.DataFrame({"time": time, "joint1": tau[0], "joint2": tau[1]}))
