"""Candidates for a missing curve: every stage, form and axis that a set could show, with knots."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from model_lab.aliases import Array
from model_lab.experiments.forward import Forward, inapplicable
from model_lab.fitting.fit import Fit
from model_lab.fitting.problem import FitProblem
from model_lab.learning.effect_file import NAMED_AXES, NOUNS, RUN_AXES, Shape, effect_of
from model_lab.localisation.axes import DRIVING_QUANTITY, axes_of, input_rate
from model_lab.measurements.measurement_set import MeasurementSet
from model_lab.rules import RULES
from softhand_model.bending.balance import rough_stretch
from softhand_model.effects import ElasticEffect, LoadEffect, SectionShape
from softhand_model.effects.effect import BENDING
from softhand_model.effects.stages import Memory, Strain

RATE_SMOOTHING = 0.3  # steps over which a rate is smoothed: more would come late ...
RATE_SMOOTHING_FOR_LAG = 0.7  # ... where nothing follows late anyway
KNOT_MARGIN = 1.05  # of the largest value, up to which knots go

# stage: (form, against) in the order in which they are tried
ALONG_RUN = ("pressure_rate", "direction", "time_since_step", "time_in_run")
KINDS = {
    "input": (
        *(("offset", axis) for axis in ("pressure", *ALONG_RUN, "run_order", "temperature")),
        *(("lag", axis) for axis in ("pressure_rate", "direction")),
    ),
    "load": (("factor", "pressure"), *(("factor", axis) for axis in RUN_AXES)),
    "elastic": (("factor", "output"), ("offset", "output")),
    "structure": (("factor", "output"), ("factor", "pressure")),
    "output": (
        *(("offset", axis) for axis in ("output", "pressure", *ALONG_RUN)),
        *(("offset", axis) for axis in RUN_AXES),
        *(("factor", axis) for axis in ("output", "pressure", "time_since_step", *RUN_AXES)),
        *(("lag", axis) for axis in ("pressure_rate", "direction")),
    ),
}


@dataclass(frozen=True)
class Scene:
    """Ranges of the quantities that a curve may depend on, in a set under a model.

    driving: input in all samples. measured: measured and predicted outputs. rates, output_rates: of
    input and output. slow: rates of input and output below which they count as at rest. step [s]:
    usual time between samples. largest: largest load [-], and the height [m] of the section there.
    """

    data: MeasurementSet
    base: str
    driving: Array
    measured: Array
    rates: Array
    output_rates: Array
    slow: tuple[float, float]
    step: float
    largest: tuple[float, float]

    @classmethod
    def of(cls, problem: FitProblem, base: Fit) -> Scene:
        """The ranges in the set of a problem, under a fitted model."""
        data = problem.data
        driving = [data.driving(run) for run in data.runs]
        table = data.table
        outputs = [table.of_run(table.value, index)[0] for index in range(len(data.runs))]
        rates = [
            [input_rate(run, values) for run, values in zip(data.runs, of_runs, strict=True)]
            for of_runs in (driving, outputs)
        ]
        predicted = table.value - base.residual
        steps = [np.diff(run.columns["time"]) for run in data.runs if "time" in run.columns]
        return cls(
            data,
            problem.base,
            np.concatenate(driving),
            np.concatenate([table.value, predicted]),
            np.concatenate(rates[0]),
            np.concatenate(rates[1]),
            (_slow(rates[0]), _slow(rates[1])),
            float(np.median(np.concatenate(steps))) if steps else 1.0,
            _largest_load(problem, base),
        )

    def shapes(self, knots: int) -> Iterator[Shape]:
        """Every candidate that the set can show, with this number of knots."""
        for stage, kinds in KINDS.items():
            for form, against in kinds:
                shape = self._shape(stage, form, against, knots)
                if shape is None:
                    continue
                effect = effect_of(shape, "learned")
                if inapplicable(effect, self.data, self.base) is None:
                    yield shape

    def refined(self, shape: Shape, knots: int) -> Shape:
        """The candidate with another number of knots; unchanged if its axis has fewer values than
        that.
        """
        finer = self._shape(shape.stage, shape.form, shape.against, knots)
        return shape if finer is None else finer

    def _shape(self, stage: str, form: str, against: str, knots: int) -> Shape | None:
        """One candidate; None where it makes no sense in this experiment or does not vary."""
        experiment = self.data.experiment
        imposed = experiment not in BENDING
        if imposed and (
            stage in ("input", "structure") or (stage, against) == ("load", "pressure")
        ):
            return None
        if stage == "structure" and experiment == "blocked_tip":
            return None
        if self.data.stretched and (stage, against) == ("output", "pressure"):
            return None  # a load cell does not know the stretch
        if stage == "elastic" and self.base == "linear" and not imposed:
            return None  # of an actuator of unknown inside that is one with output against output
        bends = experiment == "free_bending" and self.base == "pneuflex"
        if bends and (stage, form, against) == ("output", "factor", "pressure"):
            return None  # one with that of the structure, which needs no sensor to know pressures
        if imposed and stage == "elastic" and against == "output":
            against = "pressure"  # the stretch is what drives it
        names = tuple(dict.fromkeys(self.data.of_runs(against))) if against in NAMED_AXES else ()
        places = self._places(stage, against, knots)
        if places is None:
            return None
        unit, size = self._quantity(stage)
        over = (RATE_SMOOTHING_FOR_LAG if form == "lag" else RATE_SMOOTHING) * self.step
        slow = self.slow[stage == "output"]
        return Shape(
            experiment, self.base, stage, form, against, places, unit,
            self._abscissa(stage, against), size, over, slow, names,
        )  # fmt: skip

    def _quantity(self, stage: str) -> tuple[str, float]:
        """Unit and largest value of the quantity that a curve of the stage changes."""
        if stage == "input":
            return "Pa", float(np.abs(self.driving).max())
        if stage == "output":
            return self.data.unit, float(np.abs(self.data.table.value).max())
        return "", self.largest[0] or 1.0

    def _abscissa(self, stage: str, against: str) -> str:
        """What the knots are, with unit."""
        noun, unit = DRIVING_QUANTITY.get(self.data.experiment, ("pressure", "Pa"))
        if stage == "elastic":
            rubber = self.data.experiment == "rubber"
            return "root of the invariant J1 [-]" if rubber else "stretch [-]"
        if against == "pressure":
            return f"{noun} [{unit or '-'}]"
        if against == "output":
            name = self.data.outputs[0].replace("_", " ")
            return "curvature [1/m]" if stage == "structure" else f"{name} [{self.data.unit}]"
        if against == "pressure_rate":
            own = f"{self.data.unit}/s" if stage == "output" else f"{unit or '1'}/s"
            return f"rate of the {'reading' if stage == 'output' else noun} [{own}]"
        return NOUNS[against]

    # ------------------------------------------------------------------ knots
    def _places(self, stage: str, against: str, knots: int) -> tuple[float, ...] | None:
        if against in RUN_AXES:
            return self._of_runs(against, knots)
        if against == "direction":
            return (-1.0, 0.0, 1.0) if self.data.has_time else None
        if against in ("time_since_step", "time_in_run"):
            return self._times(against, knots)
        if against == "pressure_rate":
            rates = self.output_rates if stage == "output" else self.rates
            return self._signed(rates, knots) if self.data.has_time else None
        return _even(*self._range(stage, against), knots)

    def _range(self, stage: str, against: str) -> tuple[float, float]:
        if stage == "elastic" and against == "pressure":
            if self.data.experiment == "rubber":
                return 0.0, self.largest[0]
            linear = self.base == "linear"
            return (1.0, 2.0) if linear else (float(self.driving.min()), float(self.driving.max()))
        if stage == "elastic" or (stage, against) == ("structure", "output"):
            load, height = self.largest
            if self.base == "linear":
                return 1.0, 1.0 + KNOT_MARGIN * load
            stretch = float(rough_stretch(np.array(load))) - 1.0
            predicted = np.split(self.measured, 2)
            more = max(float(np.ptp(predicted[0]) / max(np.ptp(predicted[1]), 1e-300)), 1.0)
            reach = KNOT_MARGIN * stretch * min(more, 3.0)
            return (1.0, 1.0 + reach) if stage == "elastic" else (0.0, reach / height)
        if against == "pressure":
            return float(self.driving.min()), float(self.driving.max())
        shown = KNOT_MARGIN * np.split(self.measured, 2)[1]  # before the sensor
        return float(min(shown.min(), 0.0)), float(shown.max())

    def _of_runs(self, axis: str, knots: int) -> tuple[float, ...] | None:
        found = self.data.of_runs(axis)
        if axis in NAMED_AXES:
            count = len(set(found))
            return tuple(map(float, range(count))) if 1 < count <= RULES.learned_names else None
        values = np.unique(np.round(np.array(found, float), 9))
        if axis == "run_order" and len(found) < RULES.learned_runs:
            return None
        if not np.all(np.isfinite(values)) or len(values) < 2:
            return None
        if len(values) > knots:
            return _even(float(values[0]), float(values[-1]), knots)
        return tuple(values.tolist())

    def _times(self, against: str, knots: int) -> tuple[float, ...] | None:
        if not self.data.has_time:
            return None
        longest = max(float(np.ptp(run.columns["time"])) for run in self.data.runs)
        if against == "time_since_step":
            rests = [axis.values for axis in axes_of(self.data) if axis.name == against]
            if not rests:
                return None
            longest = float(np.nanmax(rests))
        return tuple((longest * np.linspace(0.0, 1.0, knots) ** 2).tolist())

    def _signed(self, rates: Array, knots: int) -> tuple[float, ...] | None:
        """Places on both sides of 0, closer near it."""
        largest = float(np.quantile(np.abs(rates), 0.98))
        if not largest > 0.0:
            return None
        steps = np.linspace(-1.0, 1.0, knots + 1 - knots % 2)
        return tuple((largest * np.sign(steps) * steps**2).tolist())


def _slow(rates: Sequence[Array]) -> float:
    """Rate below which a value rests: a tenth of its large rates, and less where some run is slow.

    rates (samples,) of every run.
    """
    sizes = [np.abs(rate) for rate in rates]
    large = RULES.resting_rate * float(np.quantile(np.concatenate(sizes), 0.9))
    rest = RULES.resting_rate
    paces = [np.median(size[size > rest * size.mean()]) for size in sizes if size.any()]
    return min([large, *(RULES.learned_resting * float(pace) for pace in paces)]) or 1.0


def _even(low: float, high: float, knots: int) -> tuple[float, ...] | None:
    return tuple(np.linspace(low, high, knots).tolist()) if high > low else None


def _largest_load(problem: FitProblem, base: Fit) -> tuple[float, float]:
    """Largest load [-] in a set under a fitted model, and the height [m] of the sections there.

    Where the strain is imposed: the root of the largest invariant J1 [-].
    """
    seen = [(0.0, 1.0)]
    only = frozenset({problem.data.experiment})

    class Load(LoadEffect):
        name = "seen_load"
        experiments = only

        def act_on_load(self, load: Array, pressure: Array, shape: SectionShape) -> Array:
            seen.append((float(np.max(load)), float(np.min(shape.height))))
            return load

    class Stretch(ElasticEffect):
        name = "seen_stretch"
        experiments = only

        def stress(
            self, stress: Array, strain: Strain, shape: SectionShape, memory: Memory, dt: Any
        ) -> Array:
            seen.append((float(np.max(strain.invariant)) ** 0.5, 1.0))
            return stress

    likelihood = base.likelihood
    named = dict.fromkeys(p.effect for p in likelihood.parameters if p.effect)
    free = [problem.classes[name] for name in named]
    probe = Load() if problem.data.experiment in BENDING else Stretch()
    fixed = (*problem.fixed, probe)
    forward = Forward(problem.data, problem.base, free, fixed, joints=problem.joints)
    forward.predict(base.values[None])
    return max(seen)
