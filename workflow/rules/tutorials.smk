# Pages of the tutorials, run from their scripts.

TUTORIALS = ["board", "hello", "one-guess", "real-arm"]
# What their scripts call.
TUTORIAL_CODE = [
    "repro.fitting.api",
    "repro.commands.boards",
    "repro.identification.exciting_motion",
    "repro.cnn.network",
]
# What scripts read. The logs of the real arm are the reader's own copies, which the page says how to download.
TUTORIAL_FILES = {
    "one-guess": [
        HERE.parent / file for file in ("data/captures/ID.bin", "data/networks/cnn.safetensors", "config/config.yaml")
    ],
}


rule tutorial:
    input:
        script=HERE.parent / "docs/tutorials/{tutorial}.py",
        read=lambda wildcards: TUTORIAL_FILES.get(wildcards.tutorial, []),
    output:
        page=f"{RESULTS}/tutorials/{{tutorial}}.md",
        figure=f"{RESULTS}/tutorials/{{tutorial}}-1.png",
    log:
        f"{LOGS}/tutorial-{{tutorial}}.log",
    benchmark:
        f"{BENCHMARKS}/tutorial-{{tutorial}}.tsv"
    conda:
        ENVIRONMENT
    params:
        *call("repro.report.tutorial:run_tutorial", *TUTORIAL_CODE),
        logs=os.environ.get("REPRO_REALDATA", "mine"),
    message:
        "Tutorial {wildcards.tutorial}"
    script:
        CALL


rule tutorials:
    input:
        expand(rules.tutorial.output, tutorial=TUTORIALS),
    localrule: True
    message:
        "The tutorials are up to date"
