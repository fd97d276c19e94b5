"""Effect file of a learned curve: an ordinary effect file of a user, and the same class that is
fitted.
"""

from __future__ import annotations

import keyword
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined, Template

from model_lab.measurements.measurement_set import OUTPUTS
from model_lab.rules import RULES
from softhand_common.documents.output_file import check_new, write_file
from softhand_model.effects import Effect, effect_classes
from softhand_model.effects.effect import BENDING
from softhand_model.effects.own.own_file import load_guarded

FACTOR_BOUNDS = (0.02, 50.0)  # bounds
TIME_BOUNDS = (1e-4, 1e3)  # [s]
OFFSET_BOUNDS = 3.0  # bounds over the size of what is offset
COURSE_AXES = {"pressure_rate": "rate", "direction": "direction", "time_since_step": "since"}
COURSE_AXES |= {"time_in_run": "time"}
NAMED_AXES = ("mount", "specimen")
RUN_AXES = ("run_order", "temperature", "wall", *NAMED_AXES)
MOST_CURVES = 3  # of a model, each in a file of its own
FLATTENS, SETS_IN, GROWS = "flattens", "sets_in", "grows"
STATIC = {(stage, "pressure") for stage in ("input", "load", "elastic")}
STATIC |= {(stage, "output") for stage in ("elastic", "output")}
Kind = tuple[str, str]
"""A stage and an axis."""
NOUNS = {
    "pressure_rate": "rate",
    "direction": "direction (-1 falls, 0 rests, 1 rises)",
    "time_since_step": "time since the last step [s]",
    "time_in_run": "time in the run [s]",
    "run_order": "number of the run among those of its specimen",
    "temperature": "temperature [K]",
    "wall": "wall [m]",
    "mount": "mount",
    "specimen": "specimen",
}
METHODS = {
    "input": ("InputEffect", "chamber_pressure(self, pressure, memory, dt)", "pressure"),
    "load": ("LoadEffect", "act_on_load(self, load, pressure, shape)", "load"),
    "modulus": ("LoadEffect", "modulus_factor(self, temperature)", ""),
    "elastic": ("ElasticEffect", "stress(self, stress, strain, shape, memory, dt)", "stress"),
    "structure": (
        "StructureEffect",
        "act_on_curvature(self, curvature, pressure, shape)",
        "curvature",
    ),
    "output": ("OutputEffect", "reading(self, value, memory, dt)", "value"),
}
RETURNS = {
    "input": "Pressure [Pa] in the chamber.",
    "load": "Load [-].",
    "modulus": "Shear modulus over its nominal value.",
    "elastic": "Elastic side [-].",
    "structure": "Free curvature [1/m].",
    "output": "Reading of the sensor.",
}


@dataclass(frozen=True)
class Shape:
    """A missing effect without its values: where, how and against what it acts.

    stage: stage of the model. form: offset, factor or lag. against: name of an axis, or
    `time_in_run`. places: knots; for an axis without order, the numbers of its `names`. size: size
    of the quantity to which an offset is added, in its unit. over [s], slow: as in
    `effects.curve.course`. unit: of that quantity. abscissa: what the knots are, in words.
    """

    experiment: str
    base: str
    stage: str
    form: str
    against: str
    places: tuple[float, ...]
    unit: str
    abscissa: str
    size: float = 1.0
    over: float = 1.0
    slow: float = 1.0
    names: tuple[str, ...] = ()

    @property
    def labels(self) -> tuple[str, ...]:
        """The knots as they are shown: names, or numbers."""
        return self.names or tuple(f"{place:.4g}" for place in self.places)

    @property
    def axis(self) -> str:
        """Name of the axis as in `localisation.axes`."""
        return "time_since_step" if self.against == "time_in_run" else self.against

    @property
    def kind(self) -> Kind:
        """(stage, axis) of the effect."""
        return self.stage, self.against

    def surprise_of(self, answer: str) -> float:
        """Minus twice the logarithm of the prior of such an effect, if it changes predictions as
        `answer` says (see `answer_of`).

        It decides only between curves that the data cannot distinguish, that is, where the output
        is nearly proportional to the input: sensors usually flatten, valves and pressure sensors
        set in late, and rubber stiffens.
        """
        if self.stage == "output" and self.against in ("pressure", "wall"):
            return RULES.unlikely_curve  # a sensor knows neither
        if self.experiment not in BENDING and self.axis == "time_since_step":
            # in one pull time and stretch are the same, and a bar is pulled to see its rubber
            return RULES.unlikely_curve
        if self.base == "linear":  # an actuator that is not linear is likelier than its sensor
            return RULES.unlikely_curve if self.kind == ("output", "output") else 0.0
        if self.kind in STATIC and self.experiment != "free_bending":
            usual = {FLATTENS: "output", SETS_IN: "input"}.get(answer, "load")
            if self.experiment not in BENDING:  # a sheet is tested in modes for its rubber's sake
                late = answer == FLATTENS and self.experiment != "rubber"
                usual = "output" if late else "elastic"
            return 0.0 if self.stage == usual else RULES.unlikely_curve
        return RULES.rare_curve if self.stage == "structure" else 0.0

    @property
    def neutral(self) -> float | None:
        """Value at which the curve does nothing; None for a lag."""
        return {"offset": 0.0, "factor": 1.0}.get(self.form)

    @property
    def bounds(self) -> tuple[float, float]:
        """Lower and upper bound of the values of the curve."""
        reach = OFFSET_BOUNDS * self.size
        return {"factor": FACTOR_BOUNDS, "lag": TIME_BOUNDS}.get(self.form, (-reach, reach))

    @property
    def start(self) -> tuple[float, float]:
        """Value from which a search begins, and standard deviation about it."""
        return {"factor": (1.0, 0.15), "lag": (0.1, 0.04)}.get(self.form, (0.0, 0.05 * self.size))

    @property
    def ordinate(self) -> str:
        """What the values of the curve are, with their unit."""
        unit = {"factor": "[-]", "lag": "[s]"}.get(self.form, f"[{self.unit or '-'}]")
        return f"{ {'lag': 'time constant'}.get(self.form, self.form) } {unit}"

    @property
    def title(self) -> str:
        """A sentence that says what the effect is."""
        what = {"input": "pressure", "output": "reading", "structure": "free curvature"}.get(
            self.stage, f"{self.stage} side"
        )
        if self.stage == "load":
            what = "shear modulus" if self.against in RUN_AXES else "load"
        how = {"offset": "An offset on", "factor": "A factor on", "lag": "A lag of"}[self.form]
        return f"{how} the {what}, against {self.abscissa}."


@lru_cache(maxsize=1)
def _template() -> Template:
    environment = Environment(
        loader=PackageLoader("model_lab", "learning"),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,
    )
    return environment.get_template("effect.py.j2")


def text_of(
    shape: Shape,
    name: str,
    learned: Sequence[float] = (),
    spread: Sequence[float] = (),
    origin: str = "",
) -> str:
    """The text of an effect file.

    name: of the effect. learned, spread: values at the knots and their standard errors; without
    values the effect has those from which a search starts. origin: what the curve was learned from,
    in words.
    """
    count = len(shape.places)
    start, width = shape.start
    low, high = shape.bounds
    named = bool(shape.names)
    stage = "modulus" if shape.stage == "load" and shape.against in RUN_AXES else shape.stage
    base, signature, given = METHODS[stage]
    least = 0.02 * width
    body, helpers = _body(shape, stage, given)
    linear_too = shape.base == "linear" and stage == "structure"
    return _template().render(
        title=shape.title,
        origin=origin,
        name=name,
        class_name="".join(part.capitalize() for part in name.split("_")),
        base=base,
        signature=signature,
        form=shape.form,
        returns=RETURNS[stage],
        helpers=sorted({*helpers, "levels" if named else "smooth_curve"}),
        body=body,
        places_name="NAMES" if named else "KNOTS",
        places=_listed(shape.names or shape.places),
        along=shape.abscissa,
        learned=_listed(list(learned) or [start] * count),
        spread=_listed([max(one, least) for one in spread] or [width] * count),
        least=f"{least:.3g}",
        ordinate=shape.ordinate,
        unit={"factor": "", "lag": "s"}.get(shape.form, shape.unit),
        low=repr(low),
        high=repr(high),
        logarithmic=shape.form == "lag",
        neutral=shape.neutral,
        experiments="{" + repr(shape.experiment) + "}",
        bases="{'pneuflex', 'linear'}" if linear_too else "",
        quantity=OUTPUTS[shape.experiment][0] if stage == "output" else "",
        remembers=shape.form == "lag" or shape.against in COURSE_AXES,
        axes=_axes(shape, stage),
        curve=f"levels(NAMES, self.values, place, {shape.neutral})"
        if named
        else "smooth_curve(KNOTS, self.values, place)",
    )


def _listed(values: Sequence[float] | Sequence[str]) -> str:
    shown = [repr(v) if isinstance(v, str) else f"{float(f'{v:.6g}')!r}" for v in values]
    return f"({', '.join(shown)}{',' if len(shown) == 1 else ''})"


def _axes(shape: Shape, stage: str) -> tuple[str, ...]:
    """Axes that reach the effect beside its method's arguments."""
    if stage == "modulus" and shape.against == "temperature":
        return ()
    beside = shape.against in RUN_AXES or (stage, shape.against) == ("output", "pressure")
    return (shape.against,) if beside else ()


def _body(shape: Shape, stage: str, given: str) -> tuple[list[str], list[str]]:
    """Lines of the method, and the helpers that they need."""
    helpers, place = [], _place(shape, stage, given)
    lines = []
    if shape.against in COURSE_AXES:
        helpers.append("course")
        lines.append(f"so_far = course({given}, memory, dt, {shape.over:.4g}, {shape.slow:.4g})")
    if shape.form == "lag":
        return [
            *lines,
            f"return lagged({given}, memory, dt, "
            f"np.maximum(self.curve({place}), {TIME_BOUNDS[0]}))",
        ], helpers
    sign = {"offset": f"{given} + ", "factor": f"{given} * " if given else ""}[shape.form]
    return [*lines, f"return {sign}self.curve({place})"], helpers


def _place(shape: Shape, stage: str, given: str) -> str:
    """What the curve is a function of, in the method of a stage."""
    if shape.against in COURSE_AXES:
        return f"so_far.{COURSE_AXES[shape.against]}"
    if shape.against in NAMED_AXES:
        return f'self.around.get("{shape.against}")'
    if stage == "modulus" and shape.against == "temperature":
        return "temperature"
    if shape.against in RUN_AXES:
        return f'self.around.get("{shape.against}", KNOTS[-1])'
    if (stage, shape.against) == ("output", "pressure"):
        return 'self.around.get("pressure", 0.0)'
    if stage == "elastic":  # one law for all modes goes by the invariant
        return "strain.invariant**0.5" if shape.experiment == "rubber" else "strain.stretch"
    return "pressure" if shape.against == "pressure" else given


def files_of(path: Path, count: int = MOST_CURVES) -> list[Path]:
    """Paths for `count` learned curves: the given path for the first, numbered ones beside it for
    the others.

    >>> [file.name for file in files_of(Path("seen.py"), 2)]
    ['seen.py', 'seen_2.py']
    """
    return [path, *(path.with_stem(f"{path.stem}_{n}") for n in range(2, count + 1))]


def check_name(path: Path, force: bool) -> None:
    """Raise ValueError if this path cannot be that of an effect file: the file exists (without
    `force`), the path does not end in .py, or its name is no Python name or that of a built-in
    effect.
    """
    for file in files_of(path):
        check_new(file, force, (".py",))
    if not path.stem.isidentifier() or keyword.iskeyword(path.stem):
        raise ValueError(f"{path}: expected a file name of letters, digits and _, got {path.stem}")
    if path.stem in effect_classes():
        raise ValueError(
            f"{path}: expected a file name that is not that of a built-in effect, got {path.stem}"
        )


def effect_of(shape: Shape, name: str) -> type[Effect]:
    """The effect class of a shape, as loaded from its effect file."""
    with tempfile.TemporaryDirectory(prefix="model-lab-") as folder:
        path = Path(folder) / f"{name}.py"
        write_file(path, text_of(shape, name))
        return load_guarded(path)[name]
