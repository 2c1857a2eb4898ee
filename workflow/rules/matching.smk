# Search for experiments that the printed numbers do not rule out. Needs the extra matching; `all` reads the kept
# data/experiments.
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
