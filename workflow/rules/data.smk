rule mean_torque:
    output:
        f"{R}/data/mean_torque.csv",
    log:
        f"{R}/logs/mean_torque.log",
    benchmark:
        f"{R}/benchmarks/mean_torque.tsv"
    conda:
        "../../envs/repro.yaml"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        config=sections("signals", "data", "images", "training"),
    message:
        "Averaging the training torques"
    script:
        "../scripts/mean_torque.py"
