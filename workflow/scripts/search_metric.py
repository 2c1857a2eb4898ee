"""Search for the formula of metr2ev and the random motion of Table 7, and check the published similarities."""

from repro.files import write_csv
from repro.paper.metric_search import (
    abstract_check,
    compare_motions,
    composition,
    least_squares_torque,
    pair_bounds,
    rank_candidates,
    score_motions,
    torque_bounds,
)
from repro.pipeline.job import job

with job(snakemake.log[0], snakemake.threads):
    settings = snakemake.params.config["metric_search"]
    scores = score_motions(settings["seed"], repeats=settings["repeats"])
    write_csv(snakemake.output.search, rank_candidates(scores))
    write_csv(snakemake.output.motions, compare_motions(scores))
    write_csv(snakemake.output.composition, composition())
    write_csv(snakemake.output.abstract, abstract_check())
    write_csv(snakemake.output.bounds, pair_bounds())
    write_csv(snakemake.output.torque_bounds, torque_bounds())
    write_csv(snakemake.output.least_squares_torque, least_squares_torque())
