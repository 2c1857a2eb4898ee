"""A few of the kept accepted experiments, with their recordings."""

from experiment_example import ROOT

from repro.experiments.accepted import read_experiments, simulate_accepted


def write_accepted(folder, config, places):
    """Files of the experiments at places of the kept list."""
    experiments, recordings = folder / "accepted.csv", folder / "recordings.safetensors"
    read_experiments(ROOT / "data/experiments/accepted.csv").iloc[places].to_csv(experiments, index=False)
    simulate_accepted(experiments, recordings, config)
    return experiments, recordings
