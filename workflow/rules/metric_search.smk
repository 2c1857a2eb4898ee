rule search_metric:
    output:
        search=f"{R}/metric/search.csv",
        composition=f"{R}/metric/composition.csv",
        abstract=f"{R}/metric/abstract.csv",
        bounds=f"{R}/metric/bounds.csv",
    log:
        f"{R}/logs/search_metric.log",
    benchmark:
        f"{R}/benchmarks/search_metric.tsv"
    conda:
        "../../envs/repro.yaml"
    resources:
        mem_mb=1500,
    params:
        code=code("search_metric.py"),
        config=sections("metric_search"),
    message:
        "Searching the formula of metr2ev that explains Table 7"
    script:
        "../scripts/search_metric.py"
