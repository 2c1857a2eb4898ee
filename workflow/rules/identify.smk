rule identify_numeric:
    input:
        weights=f"{R}/model/cnn{{suffix}}.safetensors",
        mean_torque=f"{R}/data/mean_torque.csv",
    output:
        f"{R}/identification/numeric{{suffix}}-seed{{seed}}.json",
    log:
        f"{R}/logs/identify_numeric{{suffix}}-seed{{seed}}.log",
    benchmark:
        f"{R}/benchmarks/identify_numeric{{suffix}}-seed{{seed}}.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=2000,
    params:
        config=sections("signals", "network", "data", "images", "metric", "algorithm1", "refinement", "numeric"),
    message:
        "Identifying N1 to N4, network{wildcards.suffix}, seed {wildcards.seed}"
    script:
        "../scripts/identify_numeric.py"
