rule check_coverage:
    input:
        captures=captures(["ID"]),
        weights=f"{R}/model/cnn-tracked.safetensors",
        motions=f"{R}/data/tracked.safetensors",
        mean_torque=f"{R}/data/mean_torque.csv",
    output:
        coverage=f"{R}/coverage/coverage.csv",
        ranks=f"{R}/coverage/ranks.csv",
        intervals=f"{R}/coverage/intervals.csv",
    log:
        f"{R}/logs/check_coverage.log",
    benchmark:
        f"{R}/benchmarks/check_coverage.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=2000,
        runtime=30,
    params:
        config=sections(
            *("signals", "arm", "board", "experiment", "network", "data", "image", "metric"),
            *("algorithm1", "refinement", "coverage"),
            of=of_network(config, "tracked"),
        ),
    message:
        "Checking the intervals of the network of tracked motions"
    script:
        "../scripts/check_coverage.py"


rule coverage_table:
    input:
        coverage=f"{R}/coverage/coverage.csv",
    output:
        csv=report(
            f"{R}/tables/coverage.csv",
            category="Experiment (simulated)",
            labels={"what": "Do the intervals of the network's estimate cover"},
            caption="../report/coverage_table.rst",
        ),
        tex=f"{R}/tables/coverage.tex",
        md=f"{R}/tables/coverage.md",
    log:
        f"{R}/logs/coverage_table.log",
    benchmark:
        f"{R}/benchmarks/coverage_table.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        name="coverage",
        config=sections(),
    message:
        "Do the intervals of the network's estimate cover"
    script:
        "../scripts/table.py"


rule intervals:
    input:
        intervals=f"{R}/coverage/intervals.csv",
    output:
        csv=report(
            f"{R}/tables/intervals.csv",
            category="Experiment (simulated)",
            labels={"what": "The arm's parameters with the network's intervals"},
            caption="../report/intervals.rst",
        ),
        tex=f"{R}/tables/intervals.tex",
        md=f"{R}/tables/intervals.md",
    log:
        f"{R}/logs/intervals.log",
    benchmark:
        f"{R}/benchmarks/intervals.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        name="intervals",
        config=sections(),
    message:
        "The arm's parameters with the network's intervals"
    script:
        "../scripts/table.py"


rule coverage_figure:
    input:
        ranks=f"{R}/coverage/ranks.csv",
    output:
        csv=f"{R}/figures/coverage.csv",
        pdf=f"{F}/coverage.pdf",
        png=report(
            f"{F}/coverage.png",
            category="Experiment (simulated)",
            labels={"what": "Where the truth falls in the network's intervals"},
            caption="../report/coverage.rst",
        ),
    log:
        f"{R}/logs/coverage_figure.log",
    benchmark:
        f"{R}/benchmarks/coverage_figure.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        name="coverage",
        config=sections(),
    message:
        "Where the truth falls in the network's intervals"
    script:
        "../scripts/figure.py"


rule coverage:
    input:
        f"{F}/coverage.pdf",
        f"{R}/tables/coverage.csv",
        f"{R}/tables/intervals.csv",
    message:
        "Figure and tables of the intervals are up to date"
