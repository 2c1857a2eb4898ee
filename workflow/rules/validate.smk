# Without a suffix the published network and least squares together.
rule score_numeric:
    input:
        identifications=lambda wildcards: [
            *identifications([wildcards.suffix]),
            *([] if wildcards.suffix else [NUMERIC_LEAST_SQUARES]),
        ],
    output:
        f"{R}/validation/numeric{{suffix}}.csv",
    params:
        *call("repro.experiments.identifications:score_numeric"),
        config=sections("signals", "metric", "numeric"),
    message:
        "Scoring the numeric estimates, network{wildcards.suffix}"
    script:
        CALL
