rule explain:
    input:
        weights=f"{R}/model/cnn{{suffix}}.safetensors",
        mean_torque=f"{R}/data/mean_torque.csv",
    output:
        f"{R}/why/steps{{suffix}}.csv",
    log:
        f"{R}/logs/explain{{suffix}}.log",
    benchmark:
        f"{R}/benchmarks/explain{{suffix}}.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=2000,
        runtime=30,
    params:
        config=network_sections(
            *("signals", "arm", "board", "experiment", "network", "data", "image", "metric"),
            *("algorithm1", "refinement", "why"),
        ),
    message:
        "From the ideal case to the recording, network{wildcards.suffix}"
    script:
        "../scripts/explain.py"


rule why_table:
    input:
        scores=expand(f"{R}/why/steps{{suffix}}.csv", suffix=SUFFIXES),
    output:
        csv=report(
            f"{R}/tables/why.csv",
            category="Experiment (simulated)",
            labels={"what": "From the ideal case to the recording, one cause at a time (table)"},
            caption="../report/why_table.rst",
        ),
        tex=f"{R}/tables/why.tex",
        md=f"{R}/tables/why.md",
    log:
        f"{R}/logs/why_table.log",
    benchmark:
        f"{R}/benchmarks/why_table.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        name="why",
        config=sections(),
    message:
        "From the ideal case to the recording (table)"
    script:
        "../scripts/table.py"


rule why_figure:
    input:
        scores=expand(f"{R}/why/steps{{suffix}}.csv", suffix=SUFFIXES),
    output:
        csv=f"{R}/figures/why.csv",
        pdf=f"{F}/why.pdf",
        png=report(
            f"{F}/why.png",
            category="Experiment (simulated)",
            labels={"what": "From the ideal case to the recording, one cause at a time"},
            caption="../report/why.rst",
        ),
    log:
        f"{R}/logs/why_figure.log",
    benchmark:
        f"{R}/benchmarks/why_figure.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        name="why",
        config=sections(),
    message:
        "From the ideal case to the recording (figure)"
    script:
        "../scripts/figure.py"


rule why:
    input:
        f"{F}/why.pdf",
        f"{R}/tables/why.csv",
    message:
        "Figure and table of the causes are up to date"
