# What networks are trained on.
rule simulate_tracked:
    output:
        out=TRACKED_MOTIONS,
    log:
        f"{LOGS}/simulate_tracked.log",
    benchmark:
        f"{BENCHMARKS}/simulate_tracked.tsv"
    priority: AWAITED
    conda:
        ENVIRONMENT
    params:
        *call("repro.experiments.simulated_arms:simulate_tracked"),
        config=sections("signals", "data", "board", "experiment"),
    message:
        "Simulating the arms whose motions a network is trained on"
    script:
        CALL


rule mean_torque:
    output:
        MEAN_TORQUE,
    log:
        f"{LOGS}/mean_torque.log",
    benchmark:
        f"{BENCHMARKS}/mean_torque.tsv"
    priority: AWAITED
    conda:
        ENVIRONMENT
    params:
        *call("repro.experiments.identifications:mean_torque"),
        config=sections("signals", "data", "image", "training"),
    message:
        "Averaging the training torques"
    script:
        CALL
