rule check_coverage:
    input:
        captures=captures(["ID"]),
        weights=f"{R}/model/cnn-tracked.safetensors",
        motions=TRACKED_MOTIONS,
        mean_torque=MEAN_TORQUE,
    output:
        coverage=f"{R}/coverage/coverage.csv",
        ranks=f"{R}/coverage/ranks.csv",
        intervals=f"{R}/coverage/intervals.csv",
    priority: LONG
    resources:
        runtime=30,
    params:
        *call("repro.experiments.coverage:check_coverage"),
        trained_as=configuration_digest(of_network(SETTINGS, "tracked")),
        config=sections(*USED, *ARM, "coverage", of=of_network(SETTINGS, "tracked")),
    message:
        "Checking the intervals of the network of tracked motions"
    script:
        CALL
