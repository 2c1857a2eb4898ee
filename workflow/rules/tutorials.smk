TUTORIALS = ["board", "real-arm"]


# The logs of the real arm are the reader's own copies, which the page says how to download.
rule tutorial:
    input:
        HERE.parent / "docs/tutorials/{tutorial}.py",
    output:
        page=f"{R}/tutorials/{{tutorial}}.md",
        figure=f"{R}/tutorials/{{tutorial}}-1.png",
    params:
        *code("tutorial.py", "repro.api", "repro.commands.boards", "repro.identification.exciting_motion"),
        logs=os.environ.get("REPRO_REALDATA", "mine"),
    message:
        "Tutorial {wildcards.tutorial}"
    script:
        "../scripts/tutorial.py"


rule tutorials:
    input:
        expand(rules.tutorial.output, tutorial=TUTORIALS),
    localrule: True
    message:
        "The tutorials are up to date"
