"""The configuration, declared once: every key with its type, limits, unit and meaning.

The JSON schema (`workflow/schemas/config.schema.yaml`) and the tables of `config/README.md` are generated from these
classes by `config/reference.py`; `repro.config` checks files against them.
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated, Any, Literal, TypeVar

from annotated_types import Ge, Gt, Le, Lt
from pydantic import AfterValidator, BaseModel, ConfigDict, Field
from pydantic_core import PydanticCustomError

from repro.cnn.architecture import NetworkSettings, PlainSettings, TrainingSettings
from repro.cnn.dataset import LabelSettings, UnmodelledSettings
from repro.cnn.image import ImageSettings
from repro.cnn.priors import Prior
from repro.identification.algorithm1.refinement import RefinementSettings
from repro.identification.algorithm1.search import SearchConstants
from repro.keys import (
    SECTION,
    Count,
    Flag,
    Integer,
    JointLevels,
    Joints,
    Key,
    Level,
    Positive,
    Real,
    Seed,
    Share,
    Whole,
)
from repro.signals.dct import SignalSettings
from repro.signals.metric import MetricSettings
from repro.signals.validation_motions import Circle, Profile, RandomMotion, Sinusoid


def key(meaning: str, unit: str = "", source: str = "", allowed: str = "", **field: Any) -> Any:  # noqa: ANN401
    """Describe a key: its unit, its place in the paper, and what is allowed beyond its type."""
    texts = {"unit": unit, "from": source, "allowed": allowed}
    return Field(description=meaning, json_schema_extra={name: text for name, text in texts.items() if text}, **field)


class Section(BaseModel):
    """A section without a class of its own in what it configures: each key is required."""

    model_config = ConfigDict(**SECTION, frozen=True)


def _distinct(values: list[Any]) -> list[Any]:
    if len(set(values)) < len(values):
        raise PydanticCustomError("distinct", "values that differ")
    return values


def _rising(values: list[int]) -> list[int]:
    if any(later <= earlier for earlier, later in pairwise(values)):
        raise PydanticCustomError("rising", "rising numbers")
    return values


Arms = Annotated[Integer, Ge(1), Le(100_000)]
MemorySamples = Annotated[Integer, Ge(0), Le(8192)]
T = TypeVar("T")
Unique = AfterValidator(_distinct)
Levels = Annotated[list[T], Field(min_length=1), Unique]
Rising = Annotated[list[Count], Field(min_length=1), AfterValidator(_rising)]
Seeds = Annotated[list[Seed], Field(min_length=1, max_length=1000), Unique]
NineParameters = Annotated[list[Positive], Field(min_length=9, max_length=9)]
#: Relative to the project, without "." and ".." as names.
Folder = Annotated[
    str, Field(pattern=r"^(?!.*(^|/)\.{1,2}(/|$))[A-Za-z0-9_.-]{1,200}(/[A-Za-z0-9_.-]{1,200})*$(?!\n)", max_length=200)
]


@dataclass(frozen=True)
class Tracked:
    """Simulated arms of the `links` prior whose closed-loop motions are trained on."""

    __pydantic_config__ = SECTION

    arms: Annotated[Arms, Key("number of arms", "arms")] = 320
    seed: Annotated[Seed, Key("seed of these arms")] = 1
    load_share: Annotated[Share, Key("largest gravity and Coulomb friction over the motors' full torque")] = 0.8
    least_inertia_kg_m2: Annotated[
        Joints, Key("least I1 and I3 for which the sampled loop of Table 8 is stable", "kg m^2")
    ] = (0.01, 0.004)
    largest_error_rad: Annotated[Positive, Key("arms that track worse at any instant are left out", "rad")] = 0.2
    stribeck: Annotated[Level, Key("largest Stribeck share of these arms, drawn uniformly from zero")] = 1.2
    ripple_nm: Annotated[Level, Key("largest amplitude of the ripple of these arms", "N m")] = 0.2
    ripple_cycles: Annotated[Level, Key("cycles of their ripple in a turn", "cycles")] = 11.0


@dataclass(frozen=True)
class Data(LabelSettings):
    """Training distribution."""

    __pydantic_config__ = SECTION

    motions: Annotated[
        Literal["ideal", "tracked"], Key("Eq. 10 exactly, or as arms track it (ours)", source="Section IV-A")
    ] = "ideal"
    prior: Annotated[Prior, Key("distribution of training arms, see below", source="Section IV-A")] = "mixture"
    tracked: Tracked = Tracked()


@dataclass(frozen=True)
class Training(TrainingSettings):
    """Training schedule and budget, and where the networks come from."""

    __pydantic_config__ = SECTION

    source: Annotated[
        Literal["trained", "stored"], Key("train the networks, or take the project's own", source="ours")
    ] = "trained"
    networks: Annotated[Folder, Key("folder of the stored networks", source="ours")] = "data/networks"


@dataclass(frozen=True)
class NoisyPlain(PlainSettings):
    """The plain network that reads the torque samples without an image or a guess."""

    __pydantic_config__ = SECTION

    noise: Annotated[Level, Key("standard deviation of noise on its training torques", "largest torque")] = 0.0


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
    validation_samples: Annotated[Integer, Ge(2), Le(1_000_000)] = key(
        "length of the validation motion", "samples", "Fig. 16, Table 7"
    )
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
    stribeck_velocity_rad_s: Positive = key("velocity over which the Stribeck share fades", "rad/s", "Table 10")
    ripple_nm: JointLevels = key("amplitude of a torque that turns with each joint", "N m", "Table 10")
    ripple_cycles: Level = key("cycles of the ripple in a turn of the joint", "1/turn", "Table 10")
    ripple_phase_rad: JointLevels = key("phase of the ripple", "rad", "drawn, not fitted")
    load_friction: JointLevels = key("Coulomb friction for each N m of commanded torque", "", "Table 10")
    dead_band_counts: Annotated[Integer, Ge(0), Le(1022)] = key("PWM that does not move a motor", "counts", "ours")


class Board(Section):
    """The controller of Eq. 2 and its motors."""

    kp_nm_per_rad: Joints = key("K_p of each joint", "N m/rad", "published: Table 8")
    kv_nm_per_rad: Joints = key("K_v of each joint", "N m per rad and sample", "published: Table 8, Eq. 2")
    pwm_hz: tuple[Annotated[Real, Ge(1), Le(1e9)], Annotated[Real, Ge(1), Le(1e9)]] = key(
        "PWM frequency; sent, but a simulated motor sees the mean", "Hz", "published: Table 8"
    )
    full_torque_nm: Joints = key("torque at a PWM of 1023 counts", "N m", "published: Section V-C")
    speed_limit_rad_s: Positive = key("a faster motion is not sent", "rad/s", "published: Section III")


class Experiment(Section):
    """The experiment of Section V-C."""

    source: Literal["stored", "simulated", "serial", "rtl"] = key(
        "captures, a board in process, one on the serial port, or the design in logic, simulated in process"
    )
    captures: Folder = key("folder of the stored captures: ID, T1 to T4, each `.bin`, `.json` and `.program`")
    port: Annotated[str, Field(min_length=1)] = key("device or URL, as pyserial opens it: `socket://host:port`")
    baud: Count = key("speed of that port", "bit/s", "ours")
    lead_in_s: Positive = key(
        "time from the hanging arm onto the trajectory", "s", "ours", "a sampling period at least"
    )
    margin_samples: MemorySamples = key("recorded before and after, removed by **cut**", "samples", "line 4")
    torque_share: Annotated[Real, Gt(0), Le(1)] = key(
        "share of `board.full_torque_nm` that a motion may require of the nominal arm", source="ours"
    )
    duration_s: Positive = key("length of ID", "s", "Tables 8, 10", "what the board's memory holds")
    seed: Seed = key("seed of the random motion T1", source="drawn, not fitted")
    t1: RandomMotion
    t2: Circle
    t3: Profile
    t4: Sinusoid
    threshold: Share = key("d_u for the arm", source="published: lines 8, 16; Section VI")
    search_seeds: Seeds = key("one run of Algorithm 1 and its refinement each; a table shows the median one")


class Factorial(Section):
    """The factorial over accepted experiments."""

    inner_limit: Count = key("L_exe of its searches; blocks are the accepted experiments", "guesses", "ours")
    training_seeds: Seeds = key("one network of each kind for each")
    search_seeds: Seeds = key("searches of each network on each block")
    plain: NoisyPlain


class Coverage(Section):
    """Coverage of the network's intervals."""

    arms: Arms = key("arms to calibrate on, and to test on of each kind", "arms")
    guesses: Annotated[Integer, Ge(10), Le(100_000)] = key("guesses that the network reads for each arm", "guesses")
    levels: Annotated[list[Annotated[Real, Gt(0), Lt(1)]], Field(min_length=1)] = key(
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
        "arms: `wide`, `narrow` (about the stored arm), `mismatched` (trained on wide ones, tested on others)",
    )
    frictions: Levels[Positive] = key("factors on the friction of tested arms")
    arms: Annotated[Integer, Ge(2), Le(10_000)] = key("tested arms of each prior, in every condition", "arms")
    seed: Seed = key("seed of motions, arms, effects, networks and guesses")
    cnn_fraction: Annotated[Integer, Ge(1), Le(10_000)] = key("Algorithm 1 is run in one of so many conditions")
    cells_per_job: Count = key("conditions of a job, which share excitation and prior", "conditions")
    cnn_steps: Annotated[Integer, Ge(8), Le(10_000_000)] = key(
        "optimiser steps of the networks of Algorithm 1; the rate rises over a tenth of them", "steps"
    )
    training_arms: Annotated[Integer, Ge(20), Le(10_000)] = key("arms whose motions are trained on", "arms")
    networks: Levels[Literal["posterior", "flow", "algorithm1", "algorithm1+tracked"]] = key(
        "networks, besides least squares; flow needs the extra of that name"
    )
    posterior: PlainSettings = key("size and budget of the posteriors, normal and flow")
    unmodelled: UnmodelledSettings


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
        "further budgets of the experiments in detail, with the first seed",
        "guesses",
        allowed="rising, above `guesses`",
    )
    detailed_experiments: Whole = key(
        "number of experiments, from the first, with these and the extensions", "experiments"
    )
    seeds: Seeds = key("guesses of Algorithm 1: one search each")


class Spread(Section):
    """Every method over the accepted experiments."""

    inner_limit: Count = key("L_exe of its searches", "guesses", "ours")


class Ablation(Section):
    """Interpretations of what the paper leaves open."""

    seeds: Seeds = key("guesses of Algorithm 1: one repetition each")


class Claims(Section):
    """The ledger of claims."""

    enforce: Flag = key("whether an asserted claim (`must`) that fails ends the run with a failure")


class Configuration(Section):
    """Configuration of the reproduction."""

    results: Folder = key("data, weights, identifications, tables and logs", allowed="nothing of the project in it")
    figures: Folder = key("figures", allowed="another one")
    signals: SignalSettings
    metric: MetricSettings
    network: NetworkSettings
    data: Data
    image: ImageSettings
    training: Training
    networks: Networks
    algorithm1: SearchConstants
    refinement: RefinementSettings
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
