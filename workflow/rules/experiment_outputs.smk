rule fig18:
    output:
        csv=f"{R}/figures/fig18.csv",
        pdf=f"{F}/fig18.pdf",
        png=report(
            f"{F}/fig18.png",
            category="Experiment (simulated)",
            labels={"what": "Simulated experimental set-up (Fig. 18)"},
            caption="../report/fig18.rst",
        ),
    log:
        f"{R}/logs/fig18.log",
    benchmark:
        f"{R}/benchmarks/fig18.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        name="fig18",
        config=sections("signals", "arm", "board", "experiment"),
    message:
        "Simulated experimental set-up (Fig. 18)"
    script:
        "../scripts/figure.py"


rule fig19:
    input:
        captures=captures(["ID"]),
        identifications=experiment_identifications(),
        scores=f"{R}/validation/experiment.csv",
    output:
        csv=f"{R}/figures/fig19.csv",
        pdf=f"{F}/fig19.pdf",
        png=report(
            f"{F}/fig19.png",
            category="Experiment (simulated)",
            labels={"what": "Torques and motion of the identification run (Fig. 19)"},
            caption="../report/fig19.rst",
        ),
    log:
        f"{R}/logs/fig19.log",
    benchmark:
        f"{R}/benchmarks/fig19.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        name="fig19",
        config=sections("signals", "arm", "board", "experiment"),
    message:
        "Torques and motion of the identification run (Fig. 19)"
    script:
        "../scripts/figure.py"


rule fig20:
    input:
        captures=captures(["ID"]),
        identifications=experiment_identifications(),
        scores=f"{R}/validation/experiment.csv",
    output:
        csv=f"{R}/figures/fig20.csv",
        pdf=f"{F}/fig20.pdf",
        png=report(
            f"{F}/fig20.png",
            category="Experiment (simulated)",
            labels={"what": "Spectra of the identification run's torques (Fig. 20)"},
            caption="../report/fig20.rst",
        ),
    log:
        f"{R}/logs/fig20.log",
    benchmark:
        f"{R}/benchmarks/fig20.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        name="fig20",
        config=sections("signals", "arm", "board", "experiment"),
    message:
        "Spectra of the identification run's torques (Fig. 20)"
    script:
        "../scripts/figure.py"


rule fig21:
    input:
        captures=captures(["T1", "T2", "T3", "T4"]),
    output:
        csv=f"{R}/figures/fig21.csv",
        pdf=f"{F}/fig21.pdf",
        png=report(
            f"{F}/fig21.png",
            category="Experiment (simulated)",
            labels={"what": "Paths of the tip in T1 to T4 (Fig. 21)"},
            caption="../report/fig21.rst",
        ),
    log:
        f"{R}/logs/fig21.log",
    benchmark:
        f"{R}/benchmarks/fig21.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        name="fig21",
        config=sections("signals", "arm", "board", "experiment"),
    message:
        "Paths of the tip in T1 to T4 (Fig. 21)"
    script:
        "../scripts/figure.py"


rule fig22:
    input:
        captures=captures(["T1", "T2", "T3", "T4"]),
    output:
        csv=f"{R}/figures/fig22.csv",
        pdf=f"{F}/fig22.pdf",
        png=report(
            f"{F}/fig22.png",
            category="Experiment (simulated)",
            labels={"what": "Motions of T1 to T4 (Fig. 22)"},
            caption="../report/fig22.rst",
        ),
    log:
        f"{R}/logs/fig22.log",
    benchmark:
        f"{R}/benchmarks/fig22.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        name="fig22",
        config=sections("signals", "arm", "board", "experiment"),
    message:
        "Motions of T1 to T4 (Fig. 22)"
    script:
        "../scripts/figure.py"


rule fig23:
    input:
        captures=captures(["T1", "T2", "T3", "T4"]),
        identifications=experiment_identifications(),
        scores=f"{R}/validation/experiment.csv",
    output:
        csv=f"{R}/figures/fig23.csv",
        pdf=f"{F}/fig23.pdf",
        png=report(
            f"{F}/fig23.png",
            category="Experiment (simulated)",
            labels={"what": "Torques of T1 to T4 (Fig. 23)"},
            caption="../report/fig23.rst",
        ),
    log:
        f"{R}/logs/fig23.log",
    benchmark:
        f"{R}/benchmarks/fig23.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        name="fig23",
        config=sections("signals", "arm", "board", "experiment"),
    message:
        "Torques of T1 to T4 (Fig. 23)"
    script:
        "../scripts/figure.py"


rule fig24:
    input:
        captures=captures(["T1", "T2", "T3", "T4"]),
        identifications=experiment_identifications(),
        scores=f"{R}/validation/experiment.csv",
    output:
        csv=f"{R}/figures/fig24.csv",
        pdf=f"{F}/fig24.pdf",
        png=report(
            f"{F}/fig24.png",
            category="Experiment (simulated)",
            labels={"what": "Spectra of the torques of T1 to T4 (Fig. 24)"},
            caption="../report/fig24.rst",
        ),
    log:
        f"{R}/logs/fig24.log",
    benchmark:
        f"{R}/benchmarks/fig24.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        name="fig24",
        config=sections("signals", "arm", "board", "experiment"),
    message:
        "Spectra of the torques of T1 to T4 (Fig. 24)"
    script:
        "../scripts/figure.py"


rule spread_figure:
    input:
        scores=spread_scores(),
    output:
        csv=f"{R}/figures/spread.csv",
        pdf=f"{F}/spread.pdf",
        png=report(
            f"{F}/spread.png",
            category="Experiment (simulated)",
            labels={"what": "Similarity over many specimens"},
            caption="../report/spread.rst",
        ),
    log:
        f"{R}/logs/spread_figure.log",
    benchmark:
        f"{R}/benchmarks/spread_figure.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        name="spread",
        config=sections(),
    message:
        "Similarity over many specimens"
    script:
        "../scripts/figure.py"


rule table08:
    input:
        captures=captures(["ID"]),
    output:
        csv=report(
            f"{R}/tables/table08.csv",
            category="Experiment (simulated)",
            labels={"what": "Tracking and constants of the board (Table 8)"},
            caption="../report/table08.rst",
        ),
        tex=f"{R}/tables/table08.tex",
        md=f"{R}/tables/table08.md",
    log:
        f"{R}/logs/table08.log",
    benchmark:
        f"{R}/benchmarks/table08.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        name="table08",
        config=sections("signals", "arm", "board", "experiment", "metric"),
    message:
        "Tracking and constants of the board (Table 8)"
    script:
        "../scripts/table.py"


rule table09:
    input:
        identifications=experiment_identifications(),
        scores=f"{R}/validation/experiment.csv",
    output:
        csv=report(
            f"{R}/tables/table09.csv",
            category="Experiment (simulated)",
            labels={"what": "Identified parameters of the arm (Table 9)"},
            caption="../report/table09.rst",
        ),
        tex=f"{R}/tables/table09.tex",
        md=f"{R}/tables/table09.md",
    log:
        f"{R}/logs/table09.log",
    benchmark:
        f"{R}/benchmarks/table09.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        name="table09",
        config=sections(),
    message:
        "Identified parameters of the arm (Table 9)"
    script:
        "../scripts/table.py"


rule table10:
    input:
        scores=f"{R}/validation/experiment.csv",
    output:
        csv=report(
            f"{R}/tables/table10.csv",
            category="Experiment (simulated)",
            labels={"what": "Similarity on ID and T1 to T4 (Table 10)"},
            caption="../report/table10.rst",
        ),
        tex=f"{R}/tables/table10.tex",
        md=f"{R}/tables/table10.md",
    log:
        f"{R}/logs/table10.log",
    benchmark:
        f"{R}/benchmarks/table10.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        name="table10",
        config=sections(),
    message:
        "Similarity on ID and T1 to T4 (Table 10)"
    script:
        "../scripts/table.py"


rule stability:
    input:
        identifications=experiment_identifications(),
        scores=f"{R}/validation/experiment.csv",
    output:
        csv=report(
            f"{R}/tables/stability.csv",
            category="Experiment (simulated)",
            labels={"what": "Conditions of Appendix A"},
            caption="../report/stability.rst",
        ),
        tex=f"{R}/tables/stability.tex",
        md=f"{R}/tables/stability.md",
    log:
        f"{R}/logs/stability.log",
    benchmark:
        f"{R}/benchmarks/stability.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        name="stability",
        config=sections(),
    message:
        "Conditions of Appendix A"
    script:
        "../scripts/table.py"


rule verdict:
    input:
        scores=spread_scores(),
    output:
        csv=report(
            f"{R}/tables/verdict.csv",
            category="Experiment (simulated)",
            labels={"what": "Algorithm 1 and the field's methods over many specimens"},
            caption="../report/verdict.rst",
        ),
        tex=f"{R}/tables/verdict.tex",
        md=f"{R}/tables/verdict.md",
    log:
        f"{R}/logs/verdict.log",
    benchmark:
        f"{R}/benchmarks/verdict.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        name="verdict",
        config=sections(),
    message:
        "Algorithm 1 and the field's methods over many specimens"
    script:
        "../scripts/table.py"
