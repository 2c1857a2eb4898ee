# Tables and figures: a rule for all that a module declares of the same sources, and a target for each name.

EXHIBITS_FOLDER = own_folder("src/repro/exhibits")

# What tables and figures (src/repro/exhibits) are computed from.
SOURCES = {
    "diagrams": {"diagrams": sorted(map(str, (EXHIBITS_FOLDER / "diagrams").iterdir()))},
    "board": {"synthesis": "data/board/size.csv"},
    "ID": {"captures": captures(["ID"])},
    "validation": {"captures": captures(VALIDATION)},
    "published": {"identifications": identifications([""]), "scores": f"{RESULTS}/validation/numeric.csv"},
    "networks": {
        "identifications": [*identifications(SUFFIXES), NUMERIC_LEAST_SQUARES],
        "scores": expand(f"{RESULTS}/validation/numeric{{suffix}}.csv", suffix=SUFFIXES),
    },
    "arm": {"identifications": experiment_identifications(), "scores": f"{RESULTS}/validation/experiment.csv"},
    "headline": {
        "captures": captures(PROGRAMS),
        "arm": experiment_identifications(),
        "numeric": [*identifications(SUFFIXES), NUMERIC_LEAST_SQUARES],
    },
    "spread": {"scores": f"{RESULTS}/accepted/methods.csv"},
    "coverage": {name: f"{RESULTS}/coverage/{name}.csv" for name in ("coverage", "ranks", "intervals")},
    "history": {"history": f"{RESULTS}/model/training.csv"},
    "weights": {"weights": f"{RESULTS}/model/cnn.safetensors"},
    "search": {"search": f"{RESULTS}/metric/search.csv", "motions": f"{RESULTS}/metric/motions.csv"},
    "paper_recipe": {
        "scores": expand(f"{RESULTS}/validation/numeric{{suffix}}.csv", suffix=["", *RECIPE_SUFFIXES]),
        "experiment": expand(f"{RESULTS}/validation/experiment{{suffix}}.csv", suffix=["", *RECIPE_SUFFIXES]),
    },
    "losses": {"histories": expand(f"{RESULTS}/model/training{{suffix}}.csv", suffix=["", *RECIPE_SUFFIXES])},
    "readings": {
        "results": expand(f"{RESULTS}/ablation/readings/{{reading}}.json", reading=INTERPRETATIONS),
        "losses": [f"{RESULTS}/{network_files(reading)[1]}" for reading in INTERPRETATIONS],
    },
    "factorial": {
        "scores": [
            f"{RESULTS}/factorial/{cell}-seed{seed}-search{search}.csv"
            for cell in CELLS
            for seed in SETTINGS.factorial.training_seeds
            for search in SETTINGS.factorial.search_seeds[: 1 if CELLS[cell].reader == "plain" else None]
        ],
        "references": f"{RESULTS}/factorial/references.csv",
    },
    "study": {"outcomes": expand(f"{RESULTS}/study/cells/{{job}}.csv", job=STUDY_JOBS)},
    "matching": {"starts": f"{os.path.dirname(EXPERIMENTS)}/starts.csv", "experiments": EXPERIMENTS},
    "accepted": {"scores": expand(f"{RESULTS}/accepted/experiment-{{number}}.csv", number=UNIT_OF_EXPERIMENT)},
    "ablation": {"table": f"{RESULTS}/tables/ablation.csv"},
}


def caption_file(exhibit):
    """File that Snakemake's own report reads an exhibit's caption from."""
    file = Path(".snakemake/captions", f"{exhibit.target}.rst").absolute()
    if workflow.is_main_process:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(f"{exhibit.caption}\n", encoding="utf-8")
    return str(file)


def files_of(exhibit):
    """Files of an exhibit by kind; the one of its report carries its caption."""
    shown = {
        "category": exhibit.category,
        "labels": {"what": exhibit.title if exhibit.label in exhibit.title else f"{exhibit.title} ({exhibit.label})"},
        "caption": caption_file(exhibit),
    }
    if exhibit.kind == "table":
        stem = f"{RESULTS}/tables/{exhibit.name}"
        return {"csv": report(f"{stem}.csv", **shown), "tex": f"{stem}.tex", "md": f"{stem}.md"}
    stem = f"{FIGURES}/{exhibit.name}"
    return {"csv": f"{RESULTS}/figures/{exhibit.name}.csv", "pdf": f"{stem}.pdf", "png": report(f"{stem}.png", **shown)}


# One job draws what a module declares of the same files, because starting a job takes longer than drawing.
EXHIBITS_OF_JOB = {}
for exhibit in EXHIBITS:
    EXHIBITS_OF_JOB.setdefault((exhibit.numbers.__module__.rpartition(".")[2], *exhibit.inputs), []).append(exhibit)

for (module, *sources), exhibits in EXHIBITS_OF_JOB.items():

    drawing = "_".join(["draw", module, *sources])

    rule:
        name:
            drawing
        input:
            **{key: files for source in sources for key, files in SOURCES[source].items()},
        output:
            **{f"{one.target}_{kind}": file for one in exhibits for kind, file in files_of(one).items()},
        log:
            f"{LOGS}/{drawing}.log",
        benchmark:
            f"{BENCHMARKS}/{drawing}.tsv"
        conda:
            ENVIRONMENT
        params:
            *call("repro.exhibits.declare:make_exhibits", *(one.definition for one in exhibits)),
            exhibits=[one.definition for one in exhibits],
            config=sections(*dict.fromkeys(section for one in exhibits for section in one.sections)),
        message:
            ", ".join(f"{one.title} ({one.label})" for one in exhibits)
        script:
            CALL


# Each exhibit is a target; a table and a figure of one name share one.
TARGETS = {}
for exhibit in EXHIBITS:
    for target in dict.fromkeys((exhibit.target, exhibit.name)):
        TARGETS.setdefault(target, []).append(exhibit)

for target, exhibits in TARGETS.items():

    rule:
        name:
            target
        input:
            [str(file) for exhibit in exhibits for file in files_of(exhibit).values()],
        localrule: True
        message:
            f"{target} is up to date"
