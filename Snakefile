# Rebuilds every table and figure. Stages: data -> train -> identify -> validate -> render.
import os
import sys
from pathlib import Path

from snakemake.utils import min_version

from repro import contract
from repro.exhibits.catalogue import EXHIBITS
from repro.pipeline.alive import begin_run, join_run
from repro.pipeline.code import CodeDigests
from repro.pipeline.provenance import host_fingerprint, write_provenance
from repro.pipeline.readings import READINGS
from repro.pipeline.start import accept_config, set_allocator
from repro.pipeline.stored_networks import stored_files, training_config
from repro.settings import of_network

min_version("9.0")
contract.set_variables(os.environ)  # of the jobs


configfile: "config/config.yaml"


if workflow.is_main_process:
    accept_config(
        config,
        Path(workflow.basedir) / "workflow/schemas/config.schema.yaml",
        ["config/config.yaml", *workflow.overwrite_configfiles],
    )
    begin_run(Path(".snakemake"), os.environ, unlock="--unlock" in sys.argv)
    set_allocator(os.environ)
else:
    join_run(os.environ)  # a job on a node of a cluster


R = config["results"]
F = config["figures"]
ALL_FIGURES = [exhibit.name for exhibit in EXHIBITS if exhibit.kind == "figure" and not exhibit.optional]
ALL_TABLES = [exhibit.name for exhibit in EXHIBITS if exhibit.kind == "table" and not exhibit.optional]


wildcard_constraints:
    suffix="|".join(["", *(f"-{name}" for name in config["networks"])]),
    index=r"\d+",
    motion="ID|T1|T2|T3|T4",
    reading="|".join(READINGS),
    trained="|".join(READINGS),


report: "workflow/report/workflow.rst"


include: "workflow/rules/common.smk"
include: "workflow/rules/data.smk"
include: "workflow/rules/train.smk"
include: "workflow/rules/identify.smk"
include: "workflow/rules/validate.smk"
include: "workflow/rules/metric_search.smk"
include: "workflow/rules/experiment.smk"
include: "workflow/rules/why.smk"
include: "workflow/rules/coverage.smk"
include: "workflow/rules/paper_recipe.smk"
include: "workflow/rules/ablation.smk"
include: "workflow/rules/exhibits.smk"
include: "workflow/rules/claims.smk"
include: "workflow/rules/report.smk"


if workflow.is_main_process:
    CODE.keep()


localrules:
    all,
    paper_recipe,
    ablation,


rule all:
    default_target: True
    input:
        expand(f"{F}/{{figure}}.{{ext}}", figure=ALL_FIGURES, ext=["pdf", "png"]),
        expand(f"{R}/tables/{{table}}.{{ext}}", table=ALL_TABLES, ext=["csv", "tex", "md"]),
        expand(f"{R}/{{name}}", name=["claims.csv", "claims.md", "claims.sha256", "verified.txt", "report/index.html"]),
    message:
        "All tables and figures are up to date"


# The paper's own training schedule takes longer than all the rest, so it is a target of its own.
rule paper_recipe:
    input:
        expand(f"{F}/paper_recipe.{{ext}}", ext=["pdf", "png"]),
        expand(f"{R}/tables/paper_recipe.{{ext}}", ext=["csv", "tex", "md"]),
    message:
        "Numeric experiment and the arm with the published training schedule are up to date"


# Networks for other readings of the paper take longer than the reproduction itself.
rule ablation:
    input:
        expand(f"{F}/ablation.{{ext}}", ext=["pdf", "png"]),
        expand(f"{R}/tables/ablation.{{ext}}", ext=["csv", "tex", "md"]),
    message:
        "Ablation of the readings is up to date"


onsuccess:
    write_provenance(
        Path(R) / "logs/provenance.json",
        Path(workflow.basedir),
        workflow.resource_settings.cores,
        host_fingerprint(),
    )
