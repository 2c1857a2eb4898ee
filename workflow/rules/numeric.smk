# The arms N1 to N4: identified by networks and by least squares, then scored. Tables 4 to 7.
rule identify_numeric:
    input:
        weights=f"{RESULTS}/model/cnn{{suffix}}.safetensors",
        mean_torque=MEAN_TORQUE,
    output:
        expand(
            f"{RESULTS}/identification/numeric{{suffix}}-seed{{seed}}.json",
            seed=SETTINGS.numeric.seeds,
            allow_missing=True,
        ),
    log:
        f"{LOGS}/identify_numeric{{suffix}}.log",
    benchmark:
        f"{BENCHMARKS}/identify_numeric{{suffix}}.tsv"
    priority: LONG
    conda:
        ENVIRONMENT
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
        f"{RESULTS}/identification/numeric-least-squares.json",
    log:
        f"{LOGS}/identify_numeric_least_squares.log",
    benchmark:
        f"{BENCHMARKS}/identify_numeric_least_squares.tsv"
    conda:
        ENVIRONMENT
    params:
        *call("repro.experiments.identifications:least_squares_of_arms"),
        config=sections("signals", "numeric"),
    message:
        "Identifying N1 to N4 by least squares"
    script:
        CALL


# Without a suffix the default network and least squares together.
rule score_numeric:
    input:
        identifications=lambda wildcards: [
            *identifications([wildcards.suffix]),
            *([] if wildcards.suffix else [NUMERIC_LEAST_SQUARES]),
        ],
    output:
        f"{RESULTS}/validation/numeric{{suffix}}.csv",
    log:
        f"{LOGS}/score_numeric{{suffix}}.log",
    benchmark:
        f"{BENCHMARKS}/score_numeric{{suffix}}.tsv"
    conda:
        ENVIRONMENT
    params:
        *call("repro.experiments.identifications:score_numeric"),
        config=sections("signals", "metric", "numeric"),
    message:
        "Scoring the numeric estimates, network{wildcards.suffix}"
    script:
        CALL
