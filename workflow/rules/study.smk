# Learned methods and least squares in many conditions.

# Inputs are paths, not `rules.NAME.output`: with that a job on a cluster, which has no digests of code, would run the rule
# NAME again.


# One rule, because the start of a job takes half as long as one of these simulations.
rule study_arms:
    output:
        choice=f"{RESULTS}/study/arms.safetensors",
        training=[f"{RESULTS}/study/{excitation}-{law}/training.safetensors" for excitation, law in trained(SETTINGS)],
    log:
        f"{LOGS}/study_arms.log",
    benchmark:
        f"{BENCHMARKS}/study_arms.tsv"
    priority: AWAITED
    conda:
        ENVIRONMENT
    resources:
        runtime=15,
    params:
        *call("repro_studies.methods:make_arms"),
        config={**sections(*ARM_SECTIONS, *TRAINING_SECTIONS), "study": STUDY_ARMS},
    message:
        "Choosing motions and arms of the study, and simulating arms to train on"
    script:
        CALL


rule study_train:
    input:
        training=f"{RESULTS}/study/{{excitation}}-{{law}}/training.safetensors",
    output:
        weights=f"{RESULTS}/study/{{excitation}}-{{law}}/{{network}}.safetensors",
    log:
        f"{LOGS}/study_train-{{excitation}}-{{law}}-{{network}}.log",
    benchmark:
        f"{BENCHMARKS}/study_train-{{excitation}}-{{law}}-{{network}}.tsv"
    priority: TRAINING
    conda:
        ENVIRONMENT
    resources:
        mem_mb=2000,
        runtime=60,
    params:
        *call("repro_studies.methods:train_reader"),
        checkpoint=f"{RESULTS}/study/{{excitation}}-{{law}}/.{{network}}.checkpoint.safetensors",
        config={**sections(*TRAINING_SECTIONS, "arm", "board"), "study": STUDY_TRAINED},
    message:
        "Training {wildcards.network} of {wildcards.excitation}, {wildcards.law}"
    script:
        CALL


rule study_cells:
    input:
        choice=f"{RESULTS}/study/arms.safetensors",
        training=lambda wildcards: f"{study_folder(wildcards)}/training.safetensors",
        weights=study_networks,
    output:
        f"{RESULTS}/study/cells/{{job}}.csv",
    log:
        f"{LOGS}/study_cells-{{job}}.log",
    benchmark:
        f"{BENCHMARKS}/study_cells-{{job}}.tsv"
    conda:
        ENVIRONMENT
    resources:
        mem_mb=2000,
        runtime=120,
    params:
        *call("repro_studies.methods:run_job"),
        config=sections(*ARM_SECTIONS, *TRAINING_AND_SEARCH_SECTIONS, "study"),
    message:
        "Identifying the arms of {wildcards.job}"
    script:
        CALL
