rule ablation_train:
    input:
        tracked=f"{R}/data/tracked.safetensors",
    output:
        weights=f"{R}/ablation/{{trained}}.safetensors",
        history=f"{R}/ablation/{{trained}}.csv",
    resources:
        mem_mb=3000,
        runtime=90,
    params:
        *code("ablation_train.py"),
        checkpoint=f"{R}/ablation/.{{trained}}.checkpoint.safetensors",
        config=sections(*TRAINED, "networks", "algorithm1", "board", "experiment"),
    message:
        "Training for the reading {wildcards.trained}"
    script:
        "../scripts/ablation_train.py"


rule ablation_run:
    input:
        weights=lambda wildcards: f"{R}/{network_files(wildcards.reading)[0]}",
        captures=captures(PROGRAMS),
    output:
        f"{R}/ablation/readings/{{reading}}.json",
    params:
        *code("ablation_run.py"),
        config=sections(*USED, *ARM, "networks", "numeric", "ablation"),
    message:
        "Headline numbers under the reading {wildcards.reading}"
    script:
        "../scripts/ablation_run.py"
