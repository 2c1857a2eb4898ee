rule score_paper_recipe:
    input:
        captures=captures(PROGRAMS),
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
    resources:
        mem_mb=2000,
    params:
        code=code("score_experiment.py"),
        config=sections("signals", "arm", "board", "experiment", "metric"),
    message:
        "Scoring the arm's estimates with the paper's own training"
    script:
        "../scripts/score_experiment.py"
