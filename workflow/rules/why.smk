rule explain:
    input:
        weights=f"{R}/model/cnn{{suffix}}.safetensors",
        mean_torque=f"{R}/data/mean_torque.csv",
    output:
        f"{R}/why/steps{{suffix}}.csv",
    log:
        f"{R}/logs/explain{{suffix}}.log",
    benchmark:
        f"{R}/benchmarks/explain{{suffix}}.tsv"
    priority: LONG
    conda:
        "../../envs/repro.yaml"
    resources:
        mem_mb=2000,
        runtime=30,
    params:
        code=code("explain.py"),
        trained_as=trained_as,
        config=network_sections(*ARM, "why"),
    message:
        "From the ideal case to the recording, network{wildcards.suffix}"
    script:
        "../scripts/explain.py"
