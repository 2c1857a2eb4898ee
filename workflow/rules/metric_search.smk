rule search_metric:
    output:
        search=f"{R}/metric/search.csv",
        motions=f"{R}/metric/motions.csv",
        composition=f"{R}/metric/composition.csv",
        abstract=f"{R}/metric/abstract.csv",
        bounds=f"{R}/metric/bounds.csv",
        torque_bounds=f"{R}/metric/torque_bounds.csv",
        least_squares_torque=f"{R}/metric/least_squares_torque.csv",
    params:
        *call("repro.paper.metric_search:search_metric"),
        config=sections("metric_search"),
    message:
        "Searching for the formula of metr2ev and the random motion that explain Table 7"
    script:
        CALL
