"""Which formula of metr2ev explains Table 7, and the checks of the published similarities."""

from repro.files import write_csv
from repro.paper.metric_checks import abstract_check, composition, pair_bounds
from repro.paper.metric_search import search
from repro.pipeline.job import job

with job(snakemake.log[0], snakemake.threads):
    settings = snakemake.params.config["metric_search"]
    write_csv(snakemake.output.search, search(settings["seed"], repeats=settings["repeats"]))
    write_csv(snakemake.output.composition, composition())
    write_csv(snakemake.output.abstract, abstract_check().cells)
    write_csv(snakemake.output.bounds, pair_bounds())
