# One rule for each table and figure of the catalogue (src/repro/exhibits/catalogue.py).
SOURCES = {
    "ID": {"captures": captures(["ID"])},
    "validation": {"captures": captures(VALIDATION)},
    "published": {"identifications": identifications([""]), "scores": f"{R}/validation/numeric.csv"},
    "networks": {
        "identifications": identifications(SUFFIXES),
        "scores": expand(f"{R}/validation/numeric{{suffix}}.csv", suffix=SUFFIXES),
    },
    "arm": {"identifications": experiment_identifications(), "scores": f"{R}/validation/experiment.csv"},
    "spread": {"scores": spread_scores()},
    "why": {"scores": expand(f"{R}/why/steps{{suffix}}.csv", suffix=SUFFIXES)},
    "coverage": {name: f"{R}/coverage/{name}.csv" for name in ("coverage", "ranks", "intervals")},
    "history": {"history": f"{R}/model/training.csv"},
    "weights": {"weights": f"{R}/model/cnn.safetensors"},
    "search": {"search": f"{R}/metric/search.csv"},
    "paper_recipe": {
        "scores": expand(f"{R}/validation/numeric{{suffix}}.csv", suffix=["", "-paper-recipe"]),
        "experiment": expand(f"{R}/validation/experiment{{suffix}}.csv", suffix=["", "-paper-recipe"]),
    },
    "losses": {"histories": expand(f"{R}/model/training{{suffix}}.csv", suffix=["", "-paper-recipe"])},
    "readings": {
        "results": expand(f"{R}/ablation/readings/{{reading}}.json", reading=READINGS),
        "losses": [f"{R}/ablation/{name}.json" for name, reading in READINGS.items() if reading.trained],
    },
    "ablation": {"table": f"{R}/tables/ablation.csv"},
}


def files_of(exhibit):
    """Files of an exhibit by kind; the one of its report carries its caption."""
    said = {
        "category": exhibit.category,
        "labels": {"what": exhibit.title if exhibit.label in exhibit.title else f"{exhibit.title} ({exhibit.label})"},
        "caption": f"../report/{exhibit.target}.rst",
    }
    if exhibit.kind == "table":
        stem = f"{R}/tables/{exhibit.name}"
        return {"csv": report(f"{stem}.csv", **said), "tex": f"{stem}.tex", "md": f"{stem}.md"}
    stem = f"{F}/{exhibit.name}"
    return {"csv": f"{R}/figures/{exhibit.name}.csv", "pdf": f"{stem}.pdf", "png": report(f"{stem}.png", **said)}


for exhibit in EXHIBITS:

    rule:
        name:
            exhibit.target
        input:
            **{key: files for source in exhibit.inputs for key, files in SOURCES[source].items()},
        output:
            **files_of(exhibit),
        log:
            f"{R}/logs/{exhibit.target}.log",
        benchmark:
            f"{R}/benchmarks/{exhibit.target}.tsv"
        conda:
            "../../envs/repro.yaml"
        resources:
            mem_mb=1500,
        params:
            code=code("exhibit.py", f"repro.exhibits.{exhibit.family}:MADE[{(exhibit.kind, exhibit.name)!r}]"),
            exhibit=exhibit,
            config=sections(*exhibit.sections),
        message:
            f"{exhibit.title} ({exhibit.label})"
        script:
            "../scripts/exhibit.py"
