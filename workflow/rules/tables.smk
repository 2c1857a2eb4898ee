rule table01:
    output:
        csv=report(
            f"{R}/tables/table01.csv",
            category="Method",
            labels={"what": "Related work (Table 1)"},
            caption="../report/table01.rst",
        ),
        tex=f"{R}/tables/table01.tex",
        md=f"{R}/tables/table01.md",
    log:
        f"{R}/logs/table01.log",
    benchmark:
        f"{R}/benchmarks/table01.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        name="table01",
        config=sections(),
    message:
        "Related work (Table 1)"
    script:
        "../scripts/table.py"


rule table02:
    output:
        csv=report(
            f"{R}/tables/table02.csv",
            category="Model",
            labels={"what": "Dynamic parameters (Table 2)"},
            caption="../report/table02.rst",
        ),
        tex=f"{R}/tables/table02.tex",
        md=f"{R}/tables/table02.md",
    log:
        f"{R}/logs/table02.log",
    benchmark:
        f"{R}/benchmarks/table02.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        name="table02",
        config=sections(),
    message:
        "Dynamic parameters (Table 2)"
    script:
        "../scripts/table.py"


rule table03:
    output:
        csv=report(
            f"{R}/tables/table03.csv",
            category="Model",
            labels={"what": "Features of the CNN (Table 3)"},
            caption="../report/table03.rst",
        ),
        tex=f"{R}/tables/table03.tex",
        md=f"{R}/tables/table03.md",
    log:
        f"{R}/logs/table03.log",
    benchmark:
        f"{R}/benchmarks/table03.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        name="table03",
        config=sections("signals", "network", "training"),
    message:
        "Features of the CNN (Table 3)"
    script:
        "../scripts/table.py"


rule table04:
    input:
        identifications=identifications(SUFFIXES),
        scores=expand(f"{R}/validation/numeric{{suffix}}.csv", suffix=SUFFIXES),
    output:
        csv=report(
            f"{R}/tables/table04.csv",
            category="Numeric results",
            labels={"what": "Parameters of N1 and N2 (Table 4)"},
            caption="../report/table04.rst",
        ),
        tex=f"{R}/tables/table04.tex",
        md=f"{R}/tables/table04.md",
    log:
        f"{R}/logs/table04.log",
    benchmark:
        f"{R}/benchmarks/table04.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        name="table04",
        config=sections(),
    message:
        "Parameters of N1 and N2 (Table 4)"
    script:
        "../scripts/table.py"


rule table05:
    input:
        identifications=identifications(SUFFIXES),
        scores=expand(f"{R}/validation/numeric{{suffix}}.csv", suffix=SUFFIXES),
    output:
        csv=report(
            f"{R}/tables/table05.csv",
            category="Numeric results",
            labels={"what": "Parameters of N3 and N4 (Table 5)"},
            caption="../report/table05.rst",
        ),
        tex=f"{R}/tables/table05.tex",
        md=f"{R}/tables/table05.md",
    log:
        f"{R}/logs/table05.log",
    benchmark:
        f"{R}/benchmarks/table05.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        name="table05",
        config=sections(),
    message:
        "Parameters of N3 and N4 (Table 5)"
    script:
        "../scripts/table.py"


rule table06:
    input:
        scores=expand(f"{R}/validation/numeric{{suffix}}.csv", suffix=SUFFIXES),
    output:
        csv=report(
            f"{R}/tables/table06.csv",
            category="Numeric results",
            labels={"what": "Similarity on the identification trajectory (Table 6)"},
            caption="../report/table06.rst",
        ),
        tex=f"{R}/tables/table06.tex",
        md=f"{R}/tables/table06.md",
    log:
        f"{R}/logs/table06.log",
    benchmark:
        f"{R}/benchmarks/table06.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        name="table06",
        config=sections(),
    message:
        "Similarity on the identification trajectory (Table 6)"
    script:
        "../scripts/table.py"


rule table07:
    input:
        scores=expand(f"{R}/validation/numeric{{suffix}}.csv", suffix=SUFFIXES),
    output:
        csv=report(
            f"{R}/tables/table07.csv",
            category="Numeric validation",
            labels={"what": "Similarity on the validation trajectory (Table 7)"},
            caption="../report/table07.rst",
        ),
        tex=f"{R}/tables/table07.tex",
        md=f"{R}/tables/table07.md",
    log:
        f"{R}/logs/table07.log",
    benchmark:
        f"{R}/benchmarks/table07.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        name="table07",
        config=sections(),
    message:
        "Similarity on the validation trajectory (Table 7)"
    script:
        "../scripts/table.py"


rule metric_search_table:
    input:
        search=f"{R}/metric/search.csv",
    output:
        csv=report(
            f"{R}/tables/metric_search.csv",
            category="Metric",
            labels={"what": "Ranking of the formulas of metr2ev"},
            caption="../report/metric_search_table.rst",
        ),
        tex=f"{R}/tables/metric_search.tex",
        md=f"{R}/tables/metric_search.md",
    log:
        f"{R}/logs/metric_search_table.log",
    benchmark:
        f"{R}/benchmarks/metric_search_table.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        name="metric_search",
        config=sections(),
    message:
        "Ranking of the formulas of metr2ev"
    script:
        "../scripts/table.py"
