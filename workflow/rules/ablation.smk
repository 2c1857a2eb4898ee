rule ablation_train:
    input:
        tracked=TRACKED_MOTIONS,
    output:
        weights=f"{R}/ablation/{{trained}}.safetensors",
        history=f"{R}/ablation/{{trained}}.csv",
    resources:
        mem_mb=3000,
        runtime=90,
    params:
        *call("repro_studies.ablation:train_variant"),
        checkpoint=f"{R}/ablation/.{{trained}}.checkpoint.safetensors",
        config=sections(*TRAINED, "networks", "algorithm1", "board", "experiment"),
    message:
        "Training for the reading {wildcards.trained}"
    script:
        CALL


rule ablation_run:
    input:
        weights=lambda wildcards: f"{R}/{network_files(wildcards.reading)[0]}",
        captures=captures(PROGRAMS),
    output:
        f"{R}/ablation/readings/{{reading}}.json",
    resources:
        runtime=30,
    params:
        *call("repro_studies.ablation:run_variant"),
        config=sections(*USED, *ARM, "networks", "numeric", "ablation"),
    message:
        "Headline numbers under the reading {wildcards.reading}"
    script:
        CALL
