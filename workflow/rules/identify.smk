rule identify_numeric:
    input:
        weights=f"{R}/model/cnn{{suffix}}.safetensors",
        mean_torque=MEAN_TORQUE,
    output:
        expand(
            f"{R}/identification/numeric{{suffix}}-seed{{seed}}.json",
            seed=SETTINGS.numeric.seeds,
            allow_missing=True,
        ),
    priority: LONG
    resources:
        runtime=30,
    params:
        *call("repro.experiments.networks:identify_numeric"),
        seeds=SETTINGS.numeric.seeds,
        trained_as=trained_as,
        config=network_sections("numeric"),
    message:
        "Identifying N1 to N4, network{wildcards.suffix}"
    script:
        CALL


rule identify_numeric_least_squares:
    output:
        f"{R}/identification/numeric-least-squares.json",
    params:
        *call("repro.experiments.identifications:least_squares_of_arms"),
        config=sections("signals", "numeric"),
    message:
        "Identifying N1 to N4 by least squares"
    script:
        CALL
