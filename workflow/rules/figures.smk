rule fig01:
    output:
        csv=f"{R}/figures/fig01.csv",
        pdf=f"{F}/fig01.pdf",
        png=report(
            f"{F}/fig01.png",
            category="Method",
            labels={"what": "Schematic of the arm (Fig. 1)"},
            caption="../report/fig01.rst",
        ),
    log:
        f"{R}/logs/fig01.log",
    benchmark:
        f"{R}/benchmarks/fig01.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        name="fig01",
        config=sections(),
    message:
        "Schematic of the arm (Fig. 1)"
    script:
        "../scripts/figure.py"


rule fig02:
    output:
        csv=f"{R}/figures/fig02.csv",
        pdf=f"{F}/fig02.pdf",
        png=report(
            f"{F}/fig02.png",
            category="Method",
            labels={"what": "Hardware blocks of the FPGA (Fig. 2)"},
            caption="../report/fig02.rst",
        ),
    log:
        f"{R}/logs/fig02.log",
    benchmark:
        f"{R}/benchmarks/fig02.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        name="fig02",
        config=sections(),
    message:
        "Hardware blocks of the FPGA (Fig. 2)"
    script:
        "../scripts/figure.py"


rule fig03:
    output:
        csv=f"{R}/figures/fig03.csv",
        pdf=f"{F}/fig03.pdf",
        png=report(
            f"{F}/fig03.png",
            category="Method",
            labels={"what": "Flow chart of the PD control (Fig. 3)"},
            caption="../report/fig03.rst",
        ),
    log:
        f"{R}/logs/fig03.log",
    benchmark:
        f"{R}/benchmarks/fig03.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        name="fig03",
        config=sections(),
    message:
        "Flow chart of the PD control (Fig. 3)"
    script:
        "../scripts/figure.py"


rule fig04:
    output:
        csv=f"{R}/figures/fig04.csv",
        pdf=f"{F}/fig04.pdf",
        png=report(
            f"{F}/fig04.png",
            category="Method",
            labels={"what": "Identification method (Fig. 4)"},
            caption="../report/fig04.rst",
        ),
    log:
        f"{R}/logs/fig04.log",
    benchmark:
        f"{R}/benchmarks/fig04.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        name="fig04",
        config=sections(),
    message:
        "Identification method (Fig. 4)"
    script:
        "../scripts/figure.py"


rule fig05:
    output:
        csv=f"{R}/figures/fig05.csv",
        pdf=f"{F}/fig05.pdf",
        png=report(
            f"{F}/fig05.png",
            category="Signals",
            labels={"what": "Subsampling technique (Fig. 5)"},
            caption="../report/fig05.rst",
        ),
    log:
        f"{R}/logs/fig05.log",
    benchmark:
        f"{R}/benchmarks/fig05.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        name="fig05",
        config=sections("signals", "numeric"),
    message:
        "Subsampling technique (Fig. 5)"
    script:
        "../scripts/figure.py"


rule fig06:
    output:
        csv=f"{R}/figures/fig06.csv",
        pdf=f"{F}/fig06.pdf",
        png=report(
            f"{F}/fig06.png",
            category="Signals",
            labels={"what": "Identification trajectory (Fig. 6)"},
            caption="../report/fig06.rst",
        ),
    log:
        f"{R}/logs/fig06.log",
    benchmark:
        f"{R}/benchmarks/fig06.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        name="fig06",
        config=sections("signals"),
    message:
        "Identification trajectory (Fig. 6)"
    script:
        "../scripts/figure.py"


rule fig07:
    output:
        csv=f"{R}/figures/fig07.csv",
        pdf=f"{F}/fig07.pdf",
        png=report(
            f"{F}/fig07.png",
            category="Model",
            labels={"what": "Architecture of the CNN (Fig. 7)"},
            caption="../report/fig07.rst",
        ),
    log:
        f"{R}/logs/fig07.log",
    benchmark:
        f"{R}/benchmarks/fig07.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        name="fig07",
        config=sections("signals", "network"),
    message:
        "Architecture of the CNN (Fig. 7)"
    script:
        "../scripts/figure.py"


rule fig08:
    output:
        csv=f"{R}/figures/fig08.csv",
        pdf=f"{F}/fig08.pdf",
        png=report(
            f"{F}/fig08.png",
            category="Data",
            labels={"what": "Images of the training data (Fig. 8)"},
            caption="../report/fig08.rst",
        ),
    log:
        f"{R}/logs/fig08.log",
    benchmark:
        f"{R}/benchmarks/fig08.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        name="fig08",
        config=sections("signals", "data", "image", "training"),
    message:
        "Images of the training data (Fig. 8)"
    script:
        "../scripts/figure.py"


rule fig09:
    output:
        csv=f"{R}/figures/fig09.csv",
        pdf=f"{F}/fig09.pdf",
        png=report(
            f"{F}/fig09.png",
            category="Data",
            labels={"what": "Torque distribution of the training data (Fig. 9)"},
            caption="../report/fig09.rst",
        ),
    log:
        f"{R}/logs/fig09.log",
    benchmark:
        f"{R}/benchmarks/fig09.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        name="fig09",
        config=sections("signals", "data", "image", "training"),
    message:
        "Torque distribution of the training data (Fig. 9)"
    script:
        "../scripts/figure.py"


rule fig10:
    input:
        history=f"{R}/model/training.csv",
    output:
        csv=f"{R}/figures/fig10.csv",
        pdf=f"{F}/fig10.pdf",
        png=report(
            f"{F}/fig10.png",
            category="Model",
            labels={"what": "Loss over the training (Fig. 10)"},
            caption="../report/fig10.rst",
        ),
    log:
        f"{R}/logs/fig10.log",
    benchmark:
        f"{R}/benchmarks/fig10.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        name="fig10",
        config=sections(),
    message:
        "Loss over the training (Fig. 10)"
    script:
        "../scripts/figure.py"


rule fig11:
    input:
        weights=f"{R}/model/cnn.safetensors",
    output:
        csv=f"{R}/figures/fig11.csv",
        pdf=f"{F}/fig11.pdf",
        png=report(
            f"{F}/fig11.png",
            category="Model",
            labels={"what": "Spectra of the kernels (Fig. 11)"},
            caption="../report/fig11.rst",
        ),
    log:
        f"{R}/logs/fig11.log",
    benchmark:
        f"{R}/benchmarks/fig11.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        name="fig11",
        config=sections("signals", "network"),
    message:
        "Spectra of the kernels (Fig. 11)"
    script:
        "../scripts/figure.py"


rule fig12:
    input:
        identifications=identifications([""]),
        scores=f"{R}/validation/numeric.csv",
    output:
        csv=f"{R}/figures/fig12.csv",
        pdf=f"{F}/fig12.pdf",
        png=report(
            f"{F}/fig12.png",
            category="Numeric results",
            labels={"what": "Torques of N1 and N2 (Fig. 12)"},
            caption="../report/fig12.rst",
        ),
    log:
        f"{R}/logs/fig12.log",
    benchmark:
        f"{R}/benchmarks/fig12.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        name="fig12",
        config=sections("signals", "numeric"),
    message:
        "Torques of N1 and N2 (Fig. 12)"
    script:
        "../scripts/figure.py"


rule fig13:
    input:
        identifications=identifications([""]),
        scores=f"{R}/validation/numeric.csv",
    output:
        csv=f"{R}/figures/fig13.csv",
        pdf=f"{F}/fig13.pdf",
        png=report(
            f"{F}/fig13.png",
            category="Numeric results",
            labels={"what": "Torques of N3 and N4 (Fig. 13)"},
            caption="../report/fig13.rst",
        ),
    log:
        f"{R}/logs/fig13.log",
    benchmark:
        f"{R}/benchmarks/fig13.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        name="fig13",
        config=sections("signals", "numeric"),
    message:
        "Torques of N3 and N4 (Fig. 13)"
    script:
        "../scripts/figure.py"


rule fig14:
    input:
        identifications=identifications([""]),
        scores=f"{R}/validation/numeric.csv",
    output:
        csv=f"{R}/figures/fig14.csv",
        pdf=f"{F}/fig14.pdf",
        png=report(
            f"{F}/fig14.png",
            category="Numeric results",
            labels={"what": "Spectra of the numeric torques (Fig. 14)"},
            caption="../report/fig14.rst",
        ),
    log:
        f"{R}/logs/fig14.log",
    benchmark:
        f"{R}/benchmarks/fig14.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        name="fig14",
        config=sections("signals", "numeric"),
    message:
        "Spectra of the numeric torques (Fig. 14)"
    script:
        "../scripts/figure.py"


rule fig15:
    input:
        identifications=identifications([""]),
        scores=f"{R}/validation/numeric.csv",
    output:
        csv=f"{R}/figures/fig15.csv",
        pdf=f"{F}/fig15.pdf",
        png=report(
            f"{F}/fig15.png",
            category="Numeric validation",
            labels={"what": "Validation torques (Fig. 15)"},
            caption="../report/fig15.rst",
        ),
    log:
        f"{R}/logs/fig15.log",
    benchmark:
        f"{R}/benchmarks/fig15.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        name="fig15",
        config=sections("signals", "numeric"),
    message:
        "Validation torques (Fig. 15)"
    script:
        "../scripts/figure.py"


rule fig16:
    input:
        scores=f"{R}/validation/numeric.csv",
    output:
        csv=f"{R}/figures/fig16.csv",
        pdf=f"{F}/fig16.pdf",
        png=report(
            f"{F}/fig16.png",
            category="Numeric validation",
            labels={"what": "Validation trajectory (Fig. 16)"},
            caption="../report/fig16.rst",
        ),
    log:
        f"{R}/logs/fig16.log",
    benchmark:
        f"{R}/benchmarks/fig16.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        name="fig16",
        config=sections("signals", "numeric"),
    message:
        "Validation trajectory (Fig. 16)"
    script:
        "../scripts/figure.py"


rule fig17:
    input:
        identifications=identifications([""]),
        scores=f"{R}/validation/numeric.csv",
    output:
        csv=f"{R}/figures/fig17.csv",
        pdf=f"{F}/fig17.pdf",
        png=report(
            f"{F}/fig17.png",
            category="Numeric validation",
            labels={"what": "Spectra of the validation torques (Fig. 17)"},
            caption="../report/fig17.rst",
        ),
    log:
        f"{R}/logs/fig17.log",
    benchmark:
        f"{R}/benchmarks/fig17.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        name="fig17",
        config=sections("signals", "numeric"),
    message:
        "Spectra of the validation torques (Fig. 17)"
    script:
        "../scripts/figure.py"


rule metric_search_figure:
    input:
        search=f"{R}/metric/search.csv",
    output:
        csv=f"{R}/figures/metric_search.csv",
        pdf=f"{F}/metric_search.pdf",
        png=report(
            f"{F}/metric_search.png",
            category="Metric",
            labels={"what": "Candidates for the formula of metr2ev"},
            caption="../report/metric_search.rst",
        ),
    log:
        f"{R}/logs/metric_search_figure.log",
    benchmark:
        f"{R}/benchmarks/metric_search_figure.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        name="metric_search",
        config=sections(),
    message:
        "Candidates for the formula of metr2ev"
    script:
        "../scripts/figure.py"
