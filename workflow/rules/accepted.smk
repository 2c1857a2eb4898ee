# Search for experiments that the printed numbers do not rule out, and methods on those that are accepted. The first two
# rules need the extra matching; `all` reads the kept data/experiments.
rule match_start:
    output:
        f"{RESULTS}/matching/{{hypothesis}}-{{start}}.json",
    log:
        f"{LOGS}/match_start-{{hypothesis}}-{{start}}.log",
    benchmark:
        f"{BENCHMARKS}/match_start-{{hypothesis}}-{{start}}.tsv"
    conda:
        ENVIRONMENT
    resources:
        runtime=30,
    params:
        *call("repro.matching.search:fit_start"),
        config=sections(*ARM_SECTIONS, "matching"),
    message:
        "Matching experiments, hypothesis {wildcards.hypothesis}, start {wildcards.start}"
    script:
        CALL


rule match:
    input:
        starts=[
            f"{RESULTS}/matching/{hypothesis}-{start}.json"
            for hypothesis, count in enumerate(SETTINGS.matching.starts)
            for start in range(count)
        ],
    output:
        starts=f"{RESULTS}/matching/starts.csv",
        experiments=f"{RESULTS}/matching/accepted.csv",
        misfits=f"{RESULTS}/matching/misfits.csv",
    log:
        f"{LOGS}/match.log",
    benchmark:
        f"{BENCHMARKS}/match.tsv"
    conda:
        ENVIRONMENT
    params:
        *call("repro.matching.search:collect"),
        config=sections(*ARM_SECTIONS),
    message:
        "Experiments that the printed numbers do not rule out"
    script:
        CALL


rule simulate_accepted:
    input:
        experiments=EXPERIMENTS,
    output:
        out=f"{RESULTS}/accepted/recordings.safetensors",
    log:
        f"{LOGS}/simulate_accepted.log",
    benchmark:
        f"{BENCHMARKS}/simulate_accepted.tsv"
    priority: LONG
    conda:
        ENVIRONMENT
    params:
        *call("repro.experiments.accepted:simulate_accepted"),
        config=sections(*ARM_SECTIONS),
    message:
        "Simulating the accepted experiments"
    script:
        CALL


rule score_spread:
    input:
        **ACCEPTED,
        weights=expand(f"{RESULTS}/model/cnn{{suffix}}.safetensors", suffix=["", "-tracked"]),
        mean_torque=MEAN_TORQUE,
    output:
        f"{RESULTS}/accepted/methods.csv",
    log:
        f"{LOGS}/score_spread.log",
    benchmark:
        f"{BENCHMARKS}/score_spread.tsv"
    priority: LONG
    conda:
        ENVIRONMENT
    resources:
        runtime=30,
    params:
        *call("repro.experiments.networks:score_spread"),
        trained_as={name: configuration_digest(of_network(SETTINGS, name)) for name in ("published", "tracked")},
        config=sections(*TRAINING_AND_SEARCH_SECTIONS, *ARM_SECTIONS, "networks", "spread"),
    message:
        "Every method on the accepted experiments"
    script:
        CALL


rule search_accepted:
    input:
        **ACCEPTED,
        weights=accepted_weights,
    output:
        f"{RESULTS}/accepted/experiment-{{number}}.csv",
    log:
        f"{LOGS}/search_accepted-{{number}}.log",
    benchmark:
        f"{BENCHMARKS}/search_accepted-{{number}}.tsv"
    priority: LONG
    conda:
        ENVIRONMENT
    resources:
        runtime=120,
    params:
        *call("repro.experiments.guesses:search_accepted"),
        config=sections(*TRAINING_AND_SEARCH_SECTIONS, *ARM_SECTIONS, "networks", "accepted"),
    message:
        "Algorithm 1 on accepted experiment {wildcards.number}"
    script:
        CALL
