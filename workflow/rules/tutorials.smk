TUTORIALS = ["board", "hello", "one-guess", "real-arm"]
# What their scripts call.
TUTORIAL_CODE = [
    "repro.fitting.api",
    "repro.commands.boards",
    "repro.identification.exciting_motion",
    "repro.cnn.network",
]
# The logs of the real arm are the reader's own copies, which the page says how to download.
REAL_LOGS = os.environ.get("REPRO_REALDATA", "mine")
# What their scripts read.
TUTORIAL_FILES = {
    "one-guess": [HERE.parent / f"data/{file}" for file in ("captures/ID.bin", "networks/cnn.safetensors")],
    "real-arm": [f"{REAL_LOGS}/{log}.csv" for log in ("061157", "060143", "060329")],
}


rule tutorial:
    input:
        script=HERE.parent / "docs/tutorials/{tutorial}.py",
        read=lambda wildcards: TUTORIAL_FILES.get(wildcards.tutorial, []),
    output:
        page=f"{R}/tutorials/{{tutorial}}.md",
        figure=f"{R}/tutorials/{{tutorial}}-1.png",
    params:
        *call("repro.report.tutorial:run_tutorial", *TUTORIAL_CODE),
        logs=REAL_LOGS,
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
