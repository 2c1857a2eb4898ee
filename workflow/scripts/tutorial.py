"""One tutorial with its outputs."""

import os
from pathlib import Path

from repro.pipeline.job import job
from repro.report.tutorial import run_tutorial

with job(snakemake.log[0], snakemake.threads):
    os.environ["REPRO_REALDATA"] = str(Path(snakemake.params.logs).absolute())
    run_tutorial(Path(snakemake.input[0]).absolute(), Path(snakemake.output.page).absolute())
