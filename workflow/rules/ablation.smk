# Interpretations of what the paper leaves open: a network where one needs it, and headline numbers under each.
rule ablation_train:
    input:
        tracked=TRACKED_MOTIONS,
    output:
        weights=f"{RESULTS}/ablation/{{trained}}.safetensors",
        history=f"{RESULTS}/ablation/{{trained}}.csv",
    log:
        f"{LOGS}/ablation_train-{{trained}}.log",
    benchmark:
        f"{BENCHMARKS}/ablation_train-{{trained}}.tsv"
    conda:
        ENVIRONMENT
    resources:
        mem_mb=3000,
        runtime=90,
    params:
        *call("repro_studies.ablation:train_variant"),
        checkpoint=f"{RESULTS}/ablation/.{{trained}}.checkpoint.safetensors",
        config=with_history(sections(*TRAINING_SECTIONS, "networks", "algorithm1", "board", "experiment")),
    message:
        "Training for the reading {wildcards.trained}"
    script:
        CALL


rule ablation_run:
    input:
        weights=lambda wildcards: f"{RESULTS}/{network_files(wildcards.reading)[0]}",
        captures=captures(PROGRAMS),
    output:
        f"{RESULTS}/ablation/readings/{{reading}}.json",
    log:
        f"{LOGS}/ablation_run-{{reading}}.log",
    benchmark:
        f"{BENCHMARKS}/ablation_run-{{reading}}.tsv"
    conda:
        ENVIRONMENT
    resources:
        runtime=30,
    params:
        *call("repro_studies.ablation:run_variant"),
        config=sections(*TRAINING_AND_SEARCH_SECTIONS, *ARM_SECTIONS, "networks", "numeric", "ablation"),
    message:
        "Headline numbers under the reading {wildcards.reading}"
    script:
        CALL
