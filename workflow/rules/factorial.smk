# Causes of the difference on the arm, in all combinations: a network, a search, and least squares for each.

# Modules that train its networks, by what reads the torque.
READERS = {"plain": "repro_studies.plain", "cnn": "repro.cnn.train"}


rule train_factorial:
    input:
        motions=factorial_motions,
    output:
        weights=f"{RESULTS}/factorial/{{cell}}-seed{{seed}}.safetensors",
    priority: TRAINING
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
    params:
        *call("repro_studies.factorial:score_references"),
        config=FACTORIAL_SECTIONS,
    message:
        "Least squares on the blocks of the factorial"
    script:
        CALL
