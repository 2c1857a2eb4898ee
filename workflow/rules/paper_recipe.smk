rule score_paper_recipe:
    input:
        captures=captures(["ID", "T1", "T2", "T3", "T4"]),
        identifications=expand(
            f"{R}/identification/experiment-paper-recipe-seed{{seed}}.json",
            seed=config["experiment"]["search_seeds"],
        ),
    output:
        f"{R}/validation/experiment-paper-recipe.csv",
    log:
        f"{R}/logs/score_paper_recipe.log",
    benchmark:
        f"{R}/benchmarks/score_paper_recipe.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=2000,
    params:
        config=sections("signals", "arm", "board", "experiment", "metric"),
    message:
        "Scoring the arm's estimates with the paper's own training"
    script:
        "../scripts/score_experiment.py"


rule paper_recipe_table:
    input:
        scores=expand(f"{R}/validation/numeric{{suffix}}.csv", suffix=["", "-paper-recipe"]),
        experiment=expand(f"{R}/validation/experiment{{suffix}}.csv", suffix=["", "-paper-recipe"]),
    output:
        csv=report(
            f"{R}/tables/paper_recipe.csv",
            category="Ablation",
            labels={"what": "Literal Algorithm 1 with the paper's own training"},
            caption="../report/paper_recipe_table.rst",
        ),
        tex=f"{R}/tables/paper_recipe.tex",
        md=f"{R}/tables/paper_recipe.md",
    log:
        f"{R}/logs/paper_recipe_table.log",
    benchmark:
        f"{R}/benchmarks/paper_recipe_table.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        name="paper_recipe",
        config=sections(),
    message:
        "Literal Algorithm 1 with the paper's own training"
    script:
        "../scripts/table.py"


rule paper_recipe_figure:
    input:
        histories=expand(f"{R}/model/training{{suffix}}.csv", suffix=["", "-paper-recipe"]),
    output:
        csv=f"{R}/figures/paper_recipe.csv",
        pdf=f"{F}/paper_recipe.pdf",
        png=report(
            f"{F}/paper_recipe.png",
            category="Ablation",
            labels={"what": "Loss of the paper's own training beside ours"},
            caption="../report/paper_recipe.rst",
        ),
    log:
        f"{R}/logs/paper_recipe_figure.log",
    benchmark:
        f"{R}/benchmarks/paper_recipe_figure.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        name="paper_recipe",
        config=sections("training", "networks"),
    message:
        "Loss of the paper's own training beside ours"
    script:
        "../scripts/figure.py"
