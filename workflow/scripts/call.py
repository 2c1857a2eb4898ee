"""Call the function of a rule with what it names of inputs, outputs, parameters and wildcards; write what it returns."""

from importlib import import_module
from inspect import signature
from pathlib import Path

import pandas as pd

from repro.files import write_csv, write_json, write_text
from repro.experiments.job import job

module, _, name = snakemake.params[0].partition(":")
function = getattr(import_module(module), name)  # before the job begins, which sets the threads of a loaded torch
given = {name: int(value) if value.isdigit() else value for name, value in snakemake.wildcards.items()}
given |= dict(snakemake.params.items())
if "config" in given:  # not by name, so that a new key is no other code for every job
    every = snakemake.config["training"]["checkpoint_every"]  # no result depends on it
    given["config"] = import_module("repro.config.sections").job_configuration(given["config"], every)
given["files"] = [Path(each) for each in snakemake.input]
for kind, files in (("inputs", snakemake.input), ("outputs", snakemake.output)):
    given[kind] = {}
    for name, file in files.items():
        paths = [Path(each) for each in ([file] if isinstance(file, str) else file)]
        given[kind][name] = paths
        if paths:  # else a function has its default
            given[name] = paths[0] if isinstance(file, str) else paths

with job(snakemake.log[0], snakemake.threads):
    made = function(**{name: given[name] for name in signature(function).parameters if name in given})
    if made is not None:
        for file, content in zip(snakemake.output, made if isinstance(made, list) else [made], strict=True):
            write = {pd.DataFrame: write_csv, str: write_text}.get(type(content), write_json)
            write(file, content)
