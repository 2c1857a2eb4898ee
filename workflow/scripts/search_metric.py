"""Search for the formula of metr2ev and the random motion of Table 7, and check the published similarities."""

from repro.files import write_csv
from repro.paper import metric_search
from repro.pipeline.job import job

with job(snakemake.log[0], snakemake.threads):
    settings = snakemake.params.config["metric_search"]
    scores = metric_search.score_motions(settings["seed"], repeats=settings["repeats"])
    write_csv(snakemake.output.search, metric_search.rank_candidates(scores))
    write_csv(snakemake.output.motions, metric_search.compare_motions(scores))
    write_csv(snakemake.output.composition, metric_search.composition())
    write_csv(snakemake.output.abstract, metric_search.abstract_check())
    write_csv(snakemake.output.bounds, metric_search.pair_bounds())
    write_csv(snakemake.output.torque_bounds, metric_search.torque_bounds())
    write_csv(snakemake.output.least_squares_torque, metric_search.least_squares_torque())
