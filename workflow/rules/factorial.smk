# Causes of the difference on the arm, in all combinations: a network, a search, and least squares for each.

# Modules that train its networks, by what reads the torque.
READERS = {"plain": "repro_studies.plain", "cnn": "repro.cnn.train"}


rule train_factorial:
    input:
        motions=factorial_motions,
    output:
        weights=f"{RESULTS}/factorial/{{cell}}-seed{{seed}}.safetensors",
    log:
        f"{LOGS}/train_factorial-{{cell}}-seed{{seed}}.log",
    benchmark:
        f"{BENCHMARKS}/train_factorial-{{cell}}-seed{{seed}}.tsv"
    priority: TRAINING
    conda:
        ENVIRONMENT
    resources:
        mem_mb=3000,
        runtime=90,
    params:
        "repro_studies.factorial_networks:train_cell",
        code=lambda wildcards: " ".join(training_code(READERS[CELLS[wildcards.cell].reader])),
        checkpoint=f"{RESULTS}/factorial/.{{cell}}-seed{{seed}}.checkpoint.safetensors",
        config=factorial_training_sections,
    message:
        "Training {wildcards.cell}, seed {wildcards.seed}"
    script:
        CALL


rule score_factorial:
    input:
        **ACCEPTED,
        weights=f"{RESULTS}/factorial/{{cell}}-seed{{seed}}.safetensors",
        mean_torque=MEAN_TORQUE,
    output:
        f"{RESULTS}/factorial/{{cell}}-seed{{seed}}-search{{search}}.csv",
    log:
        f"{LOGS}/score_factorial-{{cell}}-seed{{seed}}-search{{search}}.log",
    benchmark:
        f"{BENCHMARKS}/score_factorial-{{cell}}-seed{{seed}}-search{{search}}.tsv"
    conda:
        ENVIRONMENT
    resources:
        runtime=60,
    params:
        *call("repro_studies.factorial_networks:score_cell"),
        config=FACTORIAL_SECTIONS,
    message:
        "Searching with {wildcards.cell}, seed {wildcards.seed}, seed of guesses {wildcards.search}"
    script:
        CALL


rule score_factorial_references:
    input:
        **ACCEPTED,
    output:
        f"{RESULTS}/factorial/references.csv",
    log:
        f"{LOGS}/score_factorial_references.log",
    benchmark:
        f"{BENCHMARKS}/score_factorial_references.tsv"
    conda:
        ENVIRONMENT
    params:
        *call("repro_studies.factorial:score_references"),
        config=FACTORIAL_SECTIONS,
    message:
        "Least squares on the blocks of the factorial"
    script:
        CALL
