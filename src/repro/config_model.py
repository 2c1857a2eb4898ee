"""The configuration, declared once: every key with its type, limits, unit and meaning.

The JSON schema (`workflow/schemas/config.schema.yaml`) and the tables of `config/README.md` are generated from these
classes by `config/reference.py`; `repro.config` checks files against them.
"""

from itertools import pairwise
from typing import Annotated, Any, Literal, TypeVar

from pydantic import AfterValidator, ConfigDict, Field
from pydantic_core import PydanticCustomError

from repro.cnn.architecture import Precision, ScheduleName
from repro.cnn.dataset import Label
from repro.cnn.image import Scale
from repro.cnn.priors import Prior
from repro.documents import Section
from repro.identification.algorithm1.search import ImageMotion
from repro.signals.dct import FrequencyUnit
from repro.signals.metric import TimeFormula
from repro.signals.validation_motions import RangeOf


def key(meaning: str, unit: str = "", source: str = "", allowed: str = "", **field: Any) -> Any:  # noqa: ANN401
    """Describe a key: its unit, its place in the paper, and what is allowed beyond its type."""
    texts = {"unit": unit, "from": source, "allowed": allowed}
    return Field(description=meaning, json_schema_extra={name: text for name, text in texts.items() if text}, **field)


def _distinct(values: list[Any]) -> list[Any]:
    if len(set(values)) < len(values):
        raise PydanticCustomError("distinct", "values that differ")
    return values


def _rising(values: list[int]) -> list[int]:
    if any(later <= earlier for earlier, later in pairwise(values)):
        raise PydanticCustomError("rising", "rising numbers")
    return values


# Upper limits are far beyond any use: a misplaced digit must not ask for terabytes or years.
Positive = Annotated[float, Field(gt=0, le=1e9)]
Level = Annotated[float, Field(ge=0, le=1e9)]
Share = Annotated[float, Field(ge=0, le=1)]
Count = Annotated[int, Field(ge=1, le=10_000_000)]
Whole = Annotated[int, Field(ge=0, le=10_000_000)]
Width = Annotated[int, Field(ge=1, le=4096)]
Seed = Annotated[int, Field(ge=0, le=2**32 - 1)]
Arms = Annotated[int, Field(ge=1, le=100_000)]
MemorySamples = Annotated[int, Field(ge=0, le=8192)]
Pair = Field(min_length=2, max_length=2)
T = TypeVar("T")
Unique = AfterValidator(_distinct)
Levels = Annotated[list[T], Field(min_length=1), Unique]
Rising = Annotated[list[Count], Field(min_length=1), AfterValidator(_rising)]
Seeds = Annotated[list[Seed], Field(min_length=1, max_length=1000), Unique]
Joints = Annotated[list[Positive], Pair]
JointLevels = Annotated[list[Level], Pair]
MotionSamples = Annotated[int, Field(ge=101, le=8192)]
NineParameters = Annotated[list[Positive], Field(min_length=9, max_length=9)]
#: Relative to the project, without "." and ".." as names.
Folder = Annotated[
    str, Field(pattern=r"^(?!.*(^|/)\.{1,2}(/|$))[A-Za-z0-9_.-]{1,200}(/[A-Za-z0-9_.-]{1,200})*$(?!\n)", max_length=200)
]


class Signals(Section):
    """Sampling and filters."""

    sampling_period_s: Positive = key("h; 0.0025, the board's clock", "s", "published: Eq. 6, Section III")
    filter_coefficient: Level = key("c_f of the low-pass exp(-c_f omega^2)", "1/omega^2", "published: Eq. 6, 14")
    frequency_reading: FrequencyUnit = key("unit of omega; `index`: DCT-II bands", source="Eq. 6, 14")
    image_samples: Annotated[int, Field(ge=100, le=100)] = key("M, side of the image", "samples", "published: Eq. 8")
    duration_s: Positive = key(
        "length of the identification trajectory, 3 pi", "s", "published: Eq. 10", "what the board's memory holds"
    )
    normalise_motion: bool = key("divide motion signals by their maximum, as printed; bends Eq. 1", source="Eq. 8")


class Metric(Section):
    """Formulas of metr2ev."""

    time_formula: TimeFormula = key(
        "error in time: mean of (x-y)^2 in the signal's unit, or |x-y|^2 / |x|^2 (`energy`)", source="Algorithm 2"
    )
    exponent: Positive = key("power on each factor", source="published: Algorithm 2")


class Network(Section):
    """Sizes of the CNN."""

    hidden: Annotated[list[Width], Pair] = key("widths of layers 4 and 5", source="Table 3 (lost)")
    sigmoid_gain: Positive = key("c of the output's sigmoid", source="Eq. 13")


class Unmodelled(Section):
    """Torque beyond Eq. 1 in training samples, which draw from zero to these levels."""

    stribeck: Level = key("share by which Coulomb friction is higher near standstill")
    ripple: Level = key("amplitude of a ripple of 3 to 31 cycles a turn", "largest torque")
    noise: Level = key("standard deviation of noise on the subsampled torque", "largest torque")
    delay_s: Level = key("delay of the torque", "s")


class Tracked(Section):
    """Simulated arms of the `links` prior whose closed-loop motions are trained on."""

    arms: Arms = key("number of arms", "arms")
    seed: Seed = key("their seed")
    load_share: Share = key("largest gravity and Coulomb friction over the motors' full torque")
    least_inertia_kg_m2: Joints = key("least I1 and I3 for which the sampled loop of Table 8 is stable", "kg m^2")
    largest_error_rad: Positive = key("arms that track worse at any instant are left out", "rad")
    stribeck: Level = key("upper end of the arms' Stribeck level, drawn uniformly from zero")
    ripple_nm: Level = key("upper end of the amplitude of their ripple", "N m")
    ripple_cycles: Level = key("cycles of their ripple in a turn", "cycles")


class Data(Section):
    """Training distribution."""

    motions: Literal["ideal", "tracked"] = key("Eq. 10 exactly, or as arms track it (ours)", source="Section IV-A")
    prior: Prior = key("distribution of training arms, see below", source="Section IV-A")
    label: Label = key("unit of labels and guesses: the largest torque, or SI", source="Section IV-A, Eq. 9")
    guess_low: Positive = key("lower end of uniform guesses", "largest torque", "published: Section IV-A")
    guess_high: Positive = key("their upper end", "largest torque", "published: Section IV-A", "above `guess_low`")
    exact_share: Share = key("share of M_p images, whose guess is right", source="Section IV-A")
    near_share: Share = key("share of guesses with a small error", "", "ours", "with `exact_share` 1 at most")
    near_low: Positive = key("lower end of that error's log-uniform deviation", "largest torque", "ours")
    near_high: Positive = key("its upper end", "largest torque", "ours", "above `near_low`")
    unmodelled: Unmodelled
    tracked: Tracked


class Image(Section):
    """Scaling of the image."""

    scale: Scale = key("divisor of Z1: its maximum over both channels, over each, or a constant", source="Eq. 9")
    constant: Positive = key("the divisor, if `scale` is `constant`", source="ours")


class PaperSchedule(Section):
    """The paper's own training schedule."""

    images: Annotated[int, Field(ge=10, le=1_000_000)] = key("fixed set", "images", "published: Section IV-B")
    train_share: Annotated[float, Field(gt=0, lt=1)] = key(
        "share to train with; the rest tests", "", "published: Section IV-B", "an image at least on each side"
    )
    learning_rate: Positive = key("eta at the first iteration", "", "published: Section IV-B")
    learning_rate_slope: Level = key("what eta gains with each iteration", "1/step", "published: Section IV-B")
    gradient_gain: Positive = key("MT, a factor on the gradient", "", "published: Section IV-B")


class Training(Section):
    """Training schedule and budget."""

    source: Literal["trained", "stored"] = key("train the networks, or take the project's own", source="ours")
    networks: Folder = key("folder of the stored networks", source="ours")
    recipe: ScheduleName = key(
        "fresh samples at every step with Muon, or the paper's schedule", source="ours; Section IV-B"
    )
    steps: Count = key("optimiser steps; the streamed rate ends there", "steps", "ours")
    batch: Width = key("images in a step", "images", "ours")
    learning_rate: Positive = key("rate that a line brings down to zero", source="ours")
    warmup: Whole = key("steps over which the rate rises, at most a quarter of all", "steps", "ours")
    seed: Seed = key("seed of weights and samples of every network, and of the examples of Fig. 8 and 9")
    test_samples: Annotated[int, Field(ge=1, le=65536)] = key("size of the held-out set", "images", "ours")
    log_every: Count = key("steps between rows of `training.csv`", "steps")
    checkpoint_every: Count = key("steps between checkpoints", "steps")
    precision: Precision = key("arithmetic of layers 1 to 4; `auto`: bfloat16 where the processor has it")
    paper: PaperSchedule


class NoRefinement(Section):
    """The refinement of further networks: tables have names for that of the published network alone."""

    passes: Literal[0]


class Changes(Section):
    """Changes of the sections; the whole is checked as a configuration of its own."""

    data: dict[str, Any] = Field(default={})
    image: dict[str, Any] = Field(default={})
    training: dict[str, Any] = Field(default={})
    algorithm1: dict[str, Any] = Field(default={})
    refinement: NoRefinement = NoRefinement(passes=0)


class Networks(Section):
    """Networks other than the published one, which is the sections as they stand."""

    model_config = ConfigDict(alias_generator=lambda name: name.replace("_", "-"))

    tracked: Changes = key("closed-loop motions in the training, and the desired motion in line 18", source="ours")
    desired: Changes = key("the published network with the desired motion in line 18", source="ours")
    tracked_measured: Changes = key(
        "closed-loop motions in the training, and the measured motion in line 18", source="ours"
    )
    paper_recipe: Changes = key("the paper's own training, target `paper_recipe`", source="Section IV-B")
    paper_recipe_ranges: Changes = key("the same from parameters in the printed ranges", source="Section IV-B, V-A")


class Algorithm1(Section):
    """Constants of Algorithm 1."""

    executions: Count = key("N_exe", source="published: line 9")
    inner_limit: Count = key("L_exe, guesses in an execution", "guesses", "line 10")
    guess_low: Positive = key("lower end of the guesses", "largest torque", "published: line 17")
    guess_high: Positive = key("their upper end", "largest torque", "published: line 17", "above `guess_low`")
    threshold_numeric: Share = key("d_u, the similarity that ends an execution", "", "published: lines 8, 16")
    image_motion: ImageMotion = key("motion of f of the image: as listed, or the one sent (ours)", source="line 18")
    feasibility: Literal["positive", "positive-definite"] = key(
        "all nine above zero, or M(q) positive definite for every q2 and no negative friction", source="line 22"
    )


class Refinement(Section):
    """Refinement of Algorithm 1's candidates by differential evolution."""

    restarts: Whole = key("fresh guesses in addition to Algorithm 1's candidates", "guesses")
    keep: Count = key("most similar candidates that survive a pass", "candidates")
    passes: Whole = key("number of passes; 0 only in section `networks`", "passes")
    read_passes: Whole = key("first passes, whose guesses the network reads", "passes")
    reach: Positive = key("largest multiple of a difference that a candidate is moved by")
    jitter: Level = key("standard deviation of the normal noise added to every move", "largest torque")


class NumericArms(Section):
    """Nine parameters of each test arm."""

    N1: NineParameters
    N2: NineParameters
    N3: NineParameters
    N4: NineParameters


class Numeric(Section):
    """The numeric experiment of Section V-B."""

    seeds: Seeds = key("one repetition of the experiment each; a table shows the median one")
    margin_samples: MemorySamples = key("recorded before and after, removed by **cut**", "samples", "line 4")
    validation_samples: Annotated[int, Field(ge=2, le=1_000_000)] = key("length of it", "samples", "Fig. 16, Table 7")
    arms: NumericArms = key("test arms N1 to N4, in SI units", "", "published: Tables 4, 5", "9 numbers each")


class MetricSearch(Section):
    """Search for the formula of metr2ev."""

    seed: Seed = key("seed of the random trajectories")
    repeats: Count = key("trajectories for each bandwidth")


class Arm(Section):
    """The arm behind the simulated board."""

    parameters: NineParameters = key(
        "I1, I2, I3 (kg m^2); g1, g2 (N m); b1, b2 (N m s/rad); k1, k2 (N m)",
        source="Appendix A, Tables 8, 10",
        allowed="M(q) positive definite",
    )
    link_lengths_m: Joints = key("l1, l2: where the tip is", "m", "Section III", "within reach of the circle of T2")
    further_viscous_nm_s_per_rad: JointLevels = key("viscous friction that b1, b2 do not have", "N m s/rad", "Table 10")
    stribeck: JointLevels = key("share by which Coulomb friction is higher near standstill", "", "Table 10")
    stribeck_velocity_rad_s: Positive = key("velocity over which that share fades", "rad/s", "Table 10")
    ripple_nm: JointLevels = key("amplitude of a torque that turns with each joint", "N m", "Table 10")
    ripple_cycles: Level = key("its cycles in a turn of the joint", "1/turn", "Table 10")
    ripple_phase_rad: JointLevels = key("its phase", "rad", "drawn, not fitted")
    load_friction: JointLevels = key("Coulomb friction for each N m of commanded torque", "", "Table 10")
    dead_band_counts: Annotated[int, Field(ge=0, le=1022)] = key("PWM that does not move a motor", "counts", "ours")


class Board(Section):
    """The controller of Eq. 2 and its motors."""

    kp_nm_per_rad: Joints = key("K_p of each joint", "N m/rad", "published: Table 8")
    kv_nm_per_rad: Joints = key("K_v of each joint", "N m per rad and sample", "published: Table 8, Eq. 2")
    pwm_hz: Annotated[list[Annotated[float, Field(ge=1, le=1e9)]], Pair] = key(
        "PWM frequency; sent, but a simulated motor sees the mean", "Hz", "published: Table 8"
    )
    full_torque_nm: Joints = key("torque at a PWM of 1023 counts", "N m", "published: Section V-C")
    speed_limit_rad_s: Positive = key("a faster motion is not sent", "rad/s", "published: Section III")


class RandomMotion(Section):
    """T1: uniform random numbers, filtered by Eq. 14."""

    samples: MotionSamples = key("its length", "samples", "Fig. 22, 23")
    bands: Annotated[float, Field(ge=0.1, le=1e9)] = key(
        "DCT-II band where its filter has a gain of 1/e", "bands", "Eq. 14, Table 10"
    )
    range_rad: Positive = key("range, between minus and plus this", "rad", "published: Section VI")
    range_of: RangeOf = key("what has it: the filtered motion, or the numbers before the filter", source="Section VI")


class CircleMotion(Section):
    """T2: a circle of the tip."""

    samples: MotionSamples = key("its length", "samples", "Fig. 22, 23")
    turns: Positive = key("turns of the circle", "turns", "Table 10")
    centre: Annotated[float, Field(ge=0.1, le=0.9)] = key("distance of its centre from joint 1", "reach", "Table 10")


class ProfileMotion(Section):
    """T3: moves from rest to rest."""

    samples: MotionSamples = key("its length", "samples", "Fig. 22, 23")
    levels: Positive = key("factor of its levels", "", "Table 10")


class SinusoidalMotion(Section):
    """T4: a sinusoid for each joint."""

    samples: MotionSamples = key("its length", "samples", "Fig. 22, 23")
    amplitude_rad: Joints = key("amplitude of each joint", "rad", "Table 10")
    frequency_hz: Joints = key("frequency of each joint", "Hz", "Table 10")


class Experiment(Section):
    """The experiment of Section V-C."""

    source: Literal["stored", "simulated", "serial", "rtl"] = key(
        "captures, a board in process, one on the serial port, or the design in logic, simulated in process"
    )
    captures: Folder = key("folder of the stored captures: ID, T1 to T4, each `.bin` and `.json`")
    port: Annotated[str, Field(min_length=1)] = key("device or URL, as pyserial opens it: `socket://host:port`")
    baud: Count = key("speed of that port", "bit/s", "ours")
    lead_in_s: Positive = key(
        "time from the hanging arm onto the trajectory", "s", "ours", "a sampling period at least"
    )
    margin_samples: MemorySamples = key("recorded before and after, removed by **cut**", "samples", "line 4")
    torque_share: Annotated[float, Field(gt=0, le=1)] = key(
        "share of `board.full_torque_nm` that a motion may require of the nominal arm", source="ours"
    )
    duration_s: Positive = key("length of ID", "s", "Tables 8, 10", "what the board's memory holds")
    seed: Seed = key("seed of the random motion T1", source="drawn, not fitted")
    t1: RandomMotion
    t2: CircleMotion
    t3: ProfileMotion
    t4: SinusoidalMotion
    threshold: Share = key("d_u for the arm", source="published: lines 8, 16; Section VI")
    search_seeds: Seeds = key("one run of Algorithm 1 and its refinement each; a table shows the median one")


class PosteriorNetwork(Section):
    """The network of the amortised posterior."""

    width: Width = key("width of each of its three hidden layers")
    steps: Count = key("optimiser steps", "steps")
    batch: Width = key("torques in a step", "torques")
    learning_rate: Positive = key("rate that a cosine brings down to zero")


class PlainNetwork(PosteriorNetwork):
    """The plain network that reads the torque samples without an image or a guess."""

    noise: Level = key("standard deviation of noise on its training torques", "largest torque")


class Factorial(Section):
    """The factorial over accepted experiments."""

    inner_limit: Count = key("L_exe of its searches; blocks are the accepted experiments", "guesses", "ours")
    training_seeds: Seeds = key("one network of each kind for each")
    search_seeds: Seeds = key("searches of each network on each block")
    plain: PlainNetwork


class Coverage(Section):
    """Coverage of the network's intervals."""

    arms: Arms = key("arms to calibrate on, and to test on of each kind", "arms")
    guesses: Annotated[int, Field(ge=10, le=100_000)] = key("guesses that the network reads for each arm", "guesses")
    levels: Annotated[list[Annotated[float, Field(gt=0, lt=1)]], Field(min_length=1)] = key(
        "shares of arms that intervals are to cover", allowed="rising, n / (n + 1) of the n `arms` at most"
    )
    seed: Seed = key("seed of arms and guesses")


class Study(Section):
    """Where a learned method pays: the factors, their levels, and the budgets."""

    excitations: Levels[Literal["eq10", "slow", "random", "optimal"]] = key(
        "motions to identify by: Eq. 10, at half its pace, a random and a D-optimal motion"
    )
    discrepancies: Levels[Share] = key("similarity that ordinary least squares reaches on Eq. 10")
    priors: Levels[Literal["wide", "narrow", "mismatched"]] = key(
        "arms of the law that is trained on, wide or about the stored arm, or of another law than the wide one",
    )
    frictions: Levels[Positive] = key("factors on the friction of tested arms")
    arms: Annotated[int, Field(ge=2, le=10_000)] = key("tested arms of each prior, in every condition", "arms")
    seed: Seed = key("seed of motions, arms, effects, networks and guesses")
    cnn_fraction: Annotated[int, Field(ge=1, le=10_000)] = key("Algorithm 1 is run in one of so many conditions")
    cells_per_job: Count = key("conditions of a job, which share excitation and prior", "conditions")
    cnn_steps: Annotated[int, Field(ge=8, le=10_000_000)] = key(
        "optimiser steps of the networks of Algorithm 1; the rate rises over a tenth of them", "steps"
    )
    training_arms: Annotated[int, Field(ge=20, le=10_000)] = key("arms whose motions are trained on", "arms")
    networks: Levels[Literal["posterior", "flow", "algorithm1", "algorithm1+tracked"]] = key(
        "networks, besides least squares; flow needs the extra of that name"
    )
    posterior: PosteriorNetwork = key("size and budget of the posteriors, normal and flow")
    unmodelled: Unmodelled


class Matching(Section):
    """Search for experiments that the printed numbers do not rule out."""

    starts: Annotated[list[Count], Field(min_length=8, max_length=8)] = key(
        "random starts under each hypothesis", "starts"
    )
    seed: Seed = key("seed of the starts")


class Accepted(Section):
    """Algorithm 1 over the accepted experiments."""

    experiments: Folder = key("file with a row for each experiment, the smallest misfit first")
    guesses: Rising = key("budgets of guesses", "guesses", allowed="rising")
    further_guesses: Rising = key(
        "further budgets of Algorithm 1 as listed, with the first seed", "guesses", allowed="rising, above `guesses`"
    )
    detailed_experiments: Whole = key(
        "number of experiments, from the first, with these, every seed, and the extensions", "experiments"
    )
    seeds: Seeds = key("guesses of Algorithm 1: one search each; the first for all experiments")


class Spread(Section):
    """Every method over the accepted experiments."""

    inner_limit: Count = key("L_exe of its searches", "guesses", "ours")


class Ablation(Section):
    """Interpretations of what the paper leaves open."""

    seeds: Seeds = key("guesses of Algorithm 1: one repetition each")


class Claims(Section):
    """The ledger of claims."""

    enforce: bool = key("whether an asserted claim (`must`) that fails ends the run with a failure")


class Configuration(Section):
    """Configuration of the reproduction."""

    results: Folder = key("data, weights, identifications, tables and logs", allowed="nothing of the project in it")
    figures: Folder = key("figures", allowed="another one")
    signals: Signals
    metric: Metric
    network: Network
    data: Data
    image: Image
    training: Training
    networks: Networks
    algorithm1: Algorithm1
    refinement: Refinement
    numeric: Numeric
    metric_search: MetricSearch
    arm: Arm
    board: Board
    experiment: Experiment
    factorial: Factorial
    coverage: Coverage
    study: Study
    matching: Matching
    accepted: Accepted
    spread: Spread
    ablation: Ablation
    claims: Claims
