# A network for each suffix, trained or taken from the stored ones.
rule train:
    input:
        stored=stored_network,
        motions=tracked_motions,
    output:
        weights=f"{RESULTS}/model/cnn{{suffix}}.safetensors",
        history=report(
            f"{RESULTS}/model/training{{suffix}}.csv",
            category="Model",
            caption="../report/training.rst",
        ),
        card=f"{RESULTS}/model/model-card{{suffix}}.md",
    log:
        f"{LOGS}/train{{suffix}}.log",
    benchmark:
        f"{BENCHMARKS}/train{{suffix}}.tsv"
    priority: TRAINING
    conda:
        ENVIRONMENT
    # One thread, the default: two threads of one network wait for each other, two networks side by side do not.
    resources:
        mem_mb=3000,
        runtime=90,
    params:
        "repro.experiments.training:train_network",
        # Digests of the training alone: a change around it must not train again.
        *training_code("repro.cnn.train"),
        config=training_sections,
        trained_as=trained_as,
        checkpoint=f"{RESULTS}/model/.checkpoint{{suffix}}.safetensors",
    message:
        "Network{wildcards.suffix}: trained, or taken from the stored ones"
    script:
        CALL


rule training:
    input:
        expand(rules.train.output, suffix=""),
    localrule: True
    message:
        "The default network is up to date"
