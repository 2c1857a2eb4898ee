# Search for the formula of the similarity and for the random motion of Table 7.
rule search_metric:
    output:
        search=f"{RESULTS}/metric/search.csv",
        motions=f"{RESULTS}/metric/motions.csv",
        composition=f"{RESULTS}/metric/composition.csv",
        abstract=f"{RESULTS}/metric/abstract.csv",
        bounds=f"{RESULTS}/metric/bounds.csv",
        torque_bounds=f"{RESULTS}/metric/torque_bounds.csv",
        least_squares_torque=f"{RESULTS}/metric/least_squares_torque.csv",
    log:
        f"{LOGS}/search_metric.log",
    benchmark:
        f"{BENCHMARKS}/search_metric.tsv"
    conda:
        ENVIRONMENT
    params:
        *call("repro.paper.metric_search:search_metric"),
        config=sections("metric_search"),
    message:
        "Searching for the formula of metr2ev and the random motion that explain Table 7"
    script:
        CALL
