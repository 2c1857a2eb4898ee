"""Search for the formula of metr2ev and the random motion of Table 7, and check the published similarities."""

from repro.files import write_csv
from repro.paper import metric_search
from repro.paper.published import load_published
from repro.pipeline.job import job

with job(snakemake.log[0], snakemake.threads):
    settings, published = snakemake.params.config["metric_search"], load_published()
    scores = metric_search.score_motions(published, settings["seed"], settings["repeats"])
    write_csv(snakemake.output.search, metric_search.rank_candidates(scores))
    write_csv(snakemake.output.motions, metric_search.compare_motions(scores))
    write_csv(snakemake.output.composition, metric_search.composition(published))
    write_csv(snakemake.output.abstract, metric_search.abstract_check(published))
    write_csv(snakemake.output.bounds, metric_search.pair_bounds(published))
    write_csv(snakemake.output.torque_bounds, metric_search.torque_bounds(published))
    write_csv(snakemake.output.least_squares_torque, metric_search.least_squares_torque(published))
