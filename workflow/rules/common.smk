# Names, settings and files that several rules share.
#
# A suffix names a network; without one it is the default.
#   -tracked               closed-loop training, desired motion in line 18
#   -tracked-measured      closed-loop training, measured motion
#   -desired               the default network, desired motion
#   -paper-recipe          the printed training schedule
#   -paper-recipe-ranges   and the printed ranges of the training arms


CODE = CodeDigests()

# Calls the function that is a job's first parameter, with the inputs, outputs, parameters and wildcards that it names.
CALL = "../scripts/call.py"
# Packages of every job. For the record: jobs run in the environment of Snakemake, and Snakefile refuses conda.
ENVIRONMENT = "../../envs/repro.yaml"
LOGS, BENCHMARKS = f"{RESULTS}/logs", f"{RESULTS}/benchmarks"
# Files that several rules name.
MEAN_TORQUE = f"{RESULTS}/data/mean_torque.csv"
TRACKED_MOTIONS = f"{RESULTS}/data/tracked.safetensors"
TABLE_FILES = expand(f"{RESULTS}/tables/{{table}}.{{ext}}", table=ALL_TABLES, ext=["csv", "tex", "md"])
LEDGER = [f"{RESULTS}/claims.csv", f"{RESULTS}/claims.md", f"{RESULTS}/claims.sha256"]
# Accepted experiments: the kept list, recordings of them, and the unit of omega of each.
EXPERIMENTS = SETTINGS.accepted.experiments
ACCEPTED = {"experiments": EXPERIMENTS, "recordings": f"{RESULTS}/accepted/recordings.safetensors"}
UNIT_OF_EXPERIMENT = experiment_units(Path(EXPERIMENTS))
# The board as a design in logic, with what simulates it.
BOARD_DESIGN = sorted(map(str, (HERE.parent / "rtl").glob("*.*")))
# Priorities: first what others wait for, then training, then other long jobs. So no core is idle at the end.
AWAITED, TRAINING, LONG = 20, 10, 5


def own_folder(name):
    """A folder of the checkout, from the working folder where possible, so that a copied run has nothing to do."""
    folder = HERE.parent / name
    return folder.relative_to(Path.cwd()) if folder.is_relative_to(Path.cwd()) else folder


def call(function, *definitions):
    """Function that a rule's job calls, and digests of the code that it and further definitions reach; in a job none."""
    script = HERE / "scripts/call.py"
    return [function, *(CODE.of_script(script, function, *definitions) if workflow.is_main_process else [])]


# What makes training samples.
SAMPLING_CODE = ["repro.experiments.simulated_arms:training_motion", "repro.config.sections:data_settings"]


def training_code(trainer):
    """Digests of what decides the weights of a network, but not of what logs and writes around its training."""
    return CODE.of(trainer, *SAMPLING_CODE) if workflow.is_main_process else []


# Keys that do not run a job again by their section. A job that depends on one has it as a parameter: a new seed reruns only
# the jobs that search with the seeds or summarise them. A network does not depend on what is logged on the way to it.
UNTRACKED_KEYS = {
    "numeric": ["seeds"],
    "experiment": ["search_seeds", *([] if SETTINGS.experiment.source == "serial" else ["port", "baud"])],
    "training": ["source", "networks", "test_samples", "log_every", "checkpoint_every"],
}


def sections(*names, of=SETTINGS):
    """Parts of the configuration that jobs depend on: changing another part does not run them again."""
    parts = stated(of, *names)
    for name in UNTRACKED_KEYS.keys() & parts.keys():
        parts[name] = {key: value for key, value in parts[name].items() if key not in UNTRACKED_KEYS[name]}
    return parts


# Sections that jobs depend on:
ARM_SECTIONS = ("signals", "arm", "board", "experiment")  # that simulate or read the arm
TRAINING_SECTIONS = ("signals", "network", "data", "image", "training")  # that train a network
TRAINING_AND_SEARCH_SECTIONS = (*TRAINING_SECTIONS, "metric", "algorithm1", "refinement")  # that also search with it
SEARCH_SECTIONS = (
    "signals",
    "network",
    "image",
    "metric",
    "algorithm1",
    "refinement",
)  # that search with a finished network


def network_sections(*names):
    """What a job that uses a network depends on, as that network changes it, and further parts."""

    def parts(wildcards):
        own = of_network(SETTINGS, network_name(wildcards.suffix))
        return {**sections(*SEARCH_SECTIONS, *names, of=own), "training": {"precision": own.training.precision}}

    return parts


def trained_as(wildcards):
    """What the weights of a job's network say of themselves."""
    return configuration_digest(of_network(SETTINGS, network_name(wildcards.suffix)))


def with_history(parts, of=SETTINGS):
    """Sections of a job that trains, and keys that its history depends on, but not its weights."""
    history = {key: getattr(of.training, key) for key in ("test_samples", "log_every")}
    return {**parts, "training": {**parts["training"], **history}}


def training_sections(wildcards):
    """What one network and its history depend on; of a stored one, where it comes from."""
    if is_stored(wildcards):
        return {"training": {key: getattr(SETTINGS.training, key) for key in ("source", "networks")}}
    own = of_network(SETTINGS, network_name(wildcards.suffix))
    return with_history(training_config(own), own)


def factorial_motions(wildcards):
    """Motions that a network of the factorial is trained on, where they are not Eq. 10's own."""
    return TRACKED_MOTIONS if CELLS[wildcards.cell].motions == "tracked" else []


def factorial_training_sections(wildcards):
    """What a network of the factorial depends on."""
    own = FACTORIAL["plain"] if CELLS[wildcards.cell].reader == "plain" else {}
    return {**sections(*TRAINING_SECTIONS, "algorithm1", "board", "experiment"), "factorial": {"plain": own}}


# What a job of the study depends on. Of the levels of friction, only the lowest and the highest
# change arms. Sizes of jobs change nothing.
STUDY_JOBS, STUDY = jobs(SETTINGS), stated(SETTINGS, "study")["study"]
STUDY_ARMS = {key: STUDY[key] for key in ("seed", "arms", "excitations", "priors", "training_arms", "unmodelled")}
STUDY_ARMS["frictions"] = [min(STUDY["frictions"]), max(STUDY["frictions"])]
STUDY_TRAINED = {key: STUDY[key] for key in ("seed", "cnn_steps", "posterior", "unmodelled")}


def study_folder(wildcards):
    """Folder of what a job's readers learned: that of its excitation and its law."""
    cell = STUDY_JOBS[wildcards.job][0]
    return f"{RESULTS}/study/{cell.excitation}-{TRAINED_ON[cell.prior]}"


def study_networks(wildcards):
    """Weights of the networks of a job."""
    return [f"{study_folder(wildcards)}/{network}.safetensors" for network in networks(SETTINGS, wildcards.job)]


# What a search of the factorial depends on: not how many there are.
SEEDS = ("training_seeds", "search_seeds")
FACTORIAL = {key: value for key, value in stated(SETTINGS, "factorial")["factorial"].items() if key not in SEEDS}
FACTORIAL_SECTIONS = {**sections(*TRAINING_AND_SEARCH_SECTIONS, *ARM_SECTIONS), "factorial": FACTORIAL}


# Networks of the tables, by the suffix of their files; the paper's own recipe is a target of its own.
SUFFIXES = ["", "-tracked"]
RECIPE_SUFFIXES = ["-paper-recipe", "-paper-recipe-ranges"]
# Those of the arm: the motions of the training and the motion of line 18 are crossed there.
ARM_SUFFIXES = [*SUFFIXES, "-desired", "-tracked-measured"]


def weights(suffix):
    """Weights of a network: those of the first one that is trained in the same way."""
    names = ["", *(f"-{name}" for name in plain(SETTINGS.networks))]
    digests = [configuration_digest(of_network(SETTINGS, network_name(each))) for each in names]
    own = digests.index(digests[names.index(suffix)])
    return f"{RESULTS}/model/cnn{names[own]}.safetensors"


def accepted_weights(wildcards):
    """Networks that search an experiment: that of its unit of omega, and in detail that of closed-loop motions."""
    unit, own = UNIT_OF_EXPERIMENT[int(wildcards.number)], SETTINGS.signals.frequency_reading
    detailed = list(UNIT_OF_EXPERIMENT)[: SETTINGS.accepted.detailed_experiments]
    further = ["-tracked-measured"] if unit == own and int(wildcards.number) in detailed else []
    return [f"{RESULTS}/{network_of_unit(unit, own)}", *map(weights, further)]


def is_stored(wildcards):
    """Whether a network is taken from those that come with the project."""
    return SETTINGS.training.source == "stored" and wildcards.suffix in ARM_SUFFIXES


def stored_network(wildcards):
    """Files that a stored network is read from; one that is trained needs none."""
    stored = stored_files(SETTINGS.training.networks, wildcards.suffix)
    return list(stored.values()) if is_stored(wildcards) else []


def tracked_motions(wildcards):
    """Motions that a network is trained on, where they are not Eq. 10's own."""
    motions = of_network(SETTINGS, network_name(wildcards.suffix)).data.motions
    return [] if is_stored(wildcards) or motions == "ideal" else TRACKED_MOTIONS


def identifications(suffixes):
    """Results of every seed for the networks with these suffixes."""
    return expand(
        f"{RESULTS}/identification/numeric{{suffix}}-seed{{seed}}.json",
        suffix=suffixes,
        seed=SETTINGS.numeric.seeds,
    )


# Least squares has no seed: one result stands for every one.
NUMERIC_LEAST_SQUARES = f"{RESULTS}/identification/numeric-least-squares.json"


def present_files(*motions):
    """Files of stored captures; one that is missing ends the run with one line."""
    files = [file for motion in motions for file in capture_files(SETTINGS, motion)]
    if not all(map(os.path.isfile, files)):
        accept_config(config, CONFIG_FILES, motions)
    return files


def files_of_stored_folders(wildcards):
    """Files of the folders that a run reads instead of measuring or training, which the list of sources covers whole."""
    return sorted(str(path) for folder in stored_folders(SETTINGS) for path in folder.rglob("*") if path.is_file())


def captures(motions):
    """Captures of these motions with their sidecars."""
    return expand(f"{RESULTS}/experiment/{{motion}}.{{ext}}", motion=motions, ext=["bin", "program", "json"])


def experiment_identifications(suffix=""):
    """Identifications of the arm with every seed: by one network, or by those of the tables and by least squares."""
    numbered = expand(
        f"{RESULTS}/identification/experiment{{suffix}}-seed{{seed}}.json",
        suffix=suffix or ARM_SUFFIXES,
        seed=SETTINGS.experiment.search_seeds,
    )
    return numbered if suffix else [*numbered, f"{RESULTS}/identification/experiment-least-squares.json"]


# What the ledger and its tables are made from: changed afterwards, its verification fails.
LEDGER_SOURCES = {
    "captures": lambda wildcards: present_files(*PROGRAMS),
    "stored": files_of_stored_folders,
    "tables": TABLE_FILES,
    "training": f"{RESULTS}/model/training.csv",
    "scores": [f"{RESULTS}/validation/numeric.csv", f"{RESULTS}/validation/experiment.csv"],
    "identifications": [*identifications(SUFFIXES), NUMERIC_LEAST_SQUARES, *experiment_identifications()],
}
# Settings that are compared with published ones.
LEDGER_SECTIONS = {
    **sections(*ARM_SECTIONS, "metric", "data", "networks", "algorithm1", "numeric"),
    **stated(SETTINGS, "training"),
}
