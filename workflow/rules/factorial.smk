rule simulate_factorial:
    output:
        f"{R}/factorial/recordings.safetensors",
    params:
        *code("simulate_factorial.py"),
        config=sections(*ARM, "data", "factorial"),
    message:
        "Simulating the blocks of the factorial"
    script:
        "../scripts/simulate_factorial.py"


rule train_factorial:
    input:
        motions=factorial_motions,
    output:
        f"{R}/factorial/{{cell}}-seed{{seed}}.safetensors",
    priority: TRAINING
    resources:
        mem_mb=3000,
        runtime=90,
    params:
        code=lambda wildcards: " ".join(CODE.of("repro.cnn.plain" if is_plain(wildcards) else "repro.cnn.train")),
        checkpoint=f"{R}/factorial/.{{cell}}-seed{{seed}}.checkpoint.safetensors",
        config=factorial_training_sections,
    message:
        "Training {wildcards.cell}, seed {wildcards.seed}"
    script:
        "../scripts/train_factorial.py"


rule score_factorial:
    input:
        weights=f"{R}/factorial/{{cell}}-seed{{seed}}.safetensors",
        recordings=f"{R}/factorial/recordings.safetensors",
        mean_torque=f"{R}/data/mean_torque.csv",
    output:
        f"{R}/factorial/{{cell}}-seed{{seed}}-search{{search}}.csv",
    resources:
        runtime=60,
    params:
        *code("score_factorial.py"),
        config=factorial_sections(),
    message:
        "Searching with {wildcards.cell}, seed {wildcards.seed}, guesses {wildcards.search}"
    script:
        "../scripts/score_factorial.py"


rule score_factorial_references:
    input:
        f"{R}/factorial/recordings.safetensors",
    output:
        f"{R}/factorial/references.csv",
    params:
        *code("score_factorial_references.py"),
        config=factorial_sections(),
    message:
        "Least squares on the blocks of the factorial"
    script:
        "../scripts/score_factorial_references.py"
