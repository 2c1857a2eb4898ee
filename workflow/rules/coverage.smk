# How often intervals from the network's estimates contain the truth.
rule check_coverage:
    input:
        captures=captures(["ID"]),
        weights=f"{RESULTS}/model/cnn-tracked.safetensors",
        motions=TRACKED_MOTIONS,
        mean_torque=MEAN_TORQUE,
    output:
        coverage=f"{RESULTS}/coverage/coverage.csv",
        ranks=f"{RESULTS}/coverage/ranks.csv",
        intervals=f"{RESULTS}/coverage/intervals.csv",
    log:
        f"{LOGS}/check_coverage.log",
    benchmark:
        f"{BENCHMARKS}/check_coverage.tsv"
    priority: LONG
    conda:
        ENVIRONMENT
    resources:
        runtime=30,
    params:
        *call("repro.experiments.coverage:check_coverage"),
        trained_as=configuration_digest(of_network(SETTINGS, "tracked")),
        config=sections(*TRAINING_AND_SEARCH_SECTIONS, *ARM_SECTIONS, "coverage", of=of_network(SETTINGS, "tracked")),
    message:
        "Checking the intervals of the network of tracked motions"
    script:
        CALL
