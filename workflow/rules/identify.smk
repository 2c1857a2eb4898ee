rule identify_numeric:
    input:
        weights=f"{R}/model/cnn{{suffix}}.safetensors",
        mean_torque=f"{R}/data/mean_torque.csv",
    output:
        expand(
            f"{R}/identification/numeric{{suffix}}-seed{{seed}}.json",
            seed=config["numeric"]["seeds"],
            allow_missing=True,
        ),
    priority: LONG
    params:
        *code("identify_numeric.py"),
        seeds=config["numeric"]["seeds"],
        trained_as=trained_as,
        config=network_sections("numeric"),
    message:
        "Identifying N1 to N4, network{wildcards.suffix}"
    script:
        "../scripts/identify_numeric.py"


rule identify_numeric_least_squares:
    output:
        f"{R}/identification/numeric-least-squares.json",
    params:
        *code("identify_numeric_least_squares.py"),
        config=sections("signals", "numeric"),
    message:
        "Identifying N1 to N4 by least squares"
    script:
        "../scripts/identify_numeric_least_squares.py"
