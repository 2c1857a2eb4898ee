# One page with everything.

TEMPLATES = own_folder("src/repro/report")


rule report:
    input:
        claims=f"{RESULTS}/claims.csv",
        tables=TABLE_FILES,
        figures=expand(f"{FIGURES}/{{figure}}.{{ext}}", figure=ALL_FIGURES, ext=["png", "pdf"]),
        numbers=expand(f"{RESULTS}/figures/{{figure}}.csv", figure=ALL_FIGURES),
        captures=lambda wildcards: present_files(*PROGRAMS),
        templates=sorted(str(file) for file in TEMPLATES.glob("*.*") if file.suffix in (".html", ".css", ".js")),
    output:
        f"{RESULTS}/report/index.html",
    log:
        f"{LOGS}/report.log",
    benchmark:
        f"{BENCHMARKS}/report.tsv"
    conda:
        ENVIRONMENT
    params:
        *call("repro.report.page:make_report"),
        # Results that `all` does not make are shown if they exist: their digest runs the job again.
        on_request=made_on_request(Path(RESULTS), Path(FIGURES), pages_of(TEMPLATES)),
        checkout=lambda wildcards, input: os.path.dirname(input.templates[0]),
        captions={exhibit.target: exhibit.caption for exhibit in EXHIBITS},
        overlays=CONFIG_FILES[1:],
        digest=config_digest(config),
        config=stated(SETTINGS, "results", "figures", "training", "spread", "algorithm1"),
    message:
        "Report of every table, figure and published number"
    script:
        CALL
