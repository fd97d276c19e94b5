"""Measurements: loaded, made of data frames, or synthesised."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import yaml

from model_lab.api.shown import Shown, figure_of
from model_lab.bench.synthesize import NOISE
from model_lab.bench.synthesize import synthesize as synthesised
from model_lab.measurements.load import load_measurements
from model_lab.measurements.measurement_set import SET_FORMAT, MeasurementSet
from model_lab.measurements.save import write_set
from model_lab.measurements.units import display_of
from model_lab.report.loops import loops
from softhand_common.documents.output_file import plain, write_files
from softhand_common.documents.yaml_document import DocumentError
from softhand_model.effects import effect_classes

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from model_lab.report.drawing import Drawing

T = TypeVar("T")
DECIMAL_SIGNS = ("", ".", ",")


@dataclass(frozen=True, repr=False)
class Data(Shown):
    """A measurement set as a user sees it.

    set: the measurements in SI units, with which the lab calculates. notes: what was noticed when
    files were imported, such as a late clock.
    """

    set: MeasurementSet
    notes: tuple[str, ...] = ()

    @property
    def runs(self) -> dict[str, pd.DataFrame]:
        """A data frame of each run by its name, one row per sample, columns in the units of
        `units`.
        """
        import pandas as pd

        return {
            run.name: pd.DataFrame(
                {
                    name: self.set.display(name).factor * values + self.set.display(name).offset
                    for name, values in run.columns.items()
                }
            )
            for run in self.set.runs
        }

    @property
    def units(self) -> dict[str, str]:
        """Unit of each column, by name: the one that the user stated; for a column without one,
        that of daily use (kPa, deg, mm).
        """
        return {name: self.set.display(name).unit for name in self.set.runs[0].columns}

    def save(self, folder: str | Path, force: bool = False) -> None:
        """Write experiment.yaml and one CSV file per run.

        Raises ValueError if one of the files exists, unless `force`.
        """
        write_set(self.set, Path(folder), force)

    def plot(self) -> Figure:
        """Figure of the output over the input; repeated runs are drawn on top of each other."""
        return figure_of(loops(self.set, ()))

    def text(self) -> str:
        """The text that `print` shows: experiment, runs, columns with units, and notes."""
        data = self.set
        lines = [f"{data.experiment}: {data.title or 'without a title'}"]
        lines += [
            f"  {run.name}: specimen {run.specimen}, protocol {run.protocol}, "
            f"{display_of('K').shown(run.temperature)}, {run.samples} samples"
            for run in data.runs
        ]
        lines += [f"  columns [{_units(self.units)}]", *(f"note: {note}" for note in self.notes)]
        return "\n".join(lines)

    def drawings(self) -> list[Drawing]:
        """The figures that a notebook shows."""
        return [loops(self.set, ())]


def _units(units: Mapping[str, str]) -> str:
    return ", ".join(f"{name} in {unit or '-'}" for name, unit in units.items())


def set_of(data: Data | MeasurementSet | str | Path) -> MeasurementSet:
    """The measurement set in SI units behind `Data`, or in the folder of a path; a measurement set
    is returned as it is.
    """
    if isinstance(data, Data):
        return data.set
    return data if isinstance(data, MeasurementSet) else load_measurements(data)


def load(path: str | Path) -> Data:
    """The measurement set of a folder with experiment.yaml.

    Raises ValueError if the folder holds no valid set; the message names file, field, what was
    expected and what came.
    """
    return Data(load_measurements(path))


def from_frames(
    frames: Mapping[str, pd.DataFrame],
    experiment: str,
    specimens: Mapping[str, Mapping[str, Any]],
    units: Mapping[str, str],
    runs: Mapping[str, Mapping[str, Any]] | None = None,
    noise: Mapping[str, float] | None = None,
    title: str = "",
) -> Data:
    """A measurement set made of data frames, one per run.

    Args:
        frames: data frame of each run, by the name of the run, with one row per sample and the
            columns that the experiment needs, such as `time`, `pressure` and `tip_angle` of
            `free_bending`.
        experiment: free_bending, blocked_tip, uniaxial, rubber, valve_pulse or base_torque.
        specimens: entry of each specimen, by its name, as in experiment.yaml: lengths [m],
            shear_modulus [Pa], mass [kg], mount, batch.
        units: unit of each column, by its name, such as {"time": "s", "pressure": "kPa"}; columns
            that are not named here are ignored.
        runs: entry of each run, by its name, as in experiment.yaml: specimen, protocol, temperature
            [K], virgin, initial, mode. `specimen` may be left out if there is only one; a run
            without `protocol` counts as a protocol of its own.
        noise: standard deviation of the noise of a column, by its name, in the unit of the column.
        title: title of the set; "" for none.

    Raises:
        ValueError: an argument is not valid; the message names the field as in experiment.yaml,
            what was expected and what came.
    """
    alone = next(iter(specimens)) if len(specimens) == 1 else None
    given = runs or {}
    unknown = [name for name in given if name not in frames]
    if unknown:
        raise ValueError(
            f"runs: expected some of the names in `frames`: {', '.join(frames)}, got {unknown[0]}"
        )
    first = {"specimen": alone} if alone else {}
    files = {name: f"{number}.csv" for number, name in enumerate(frames)}
    document = {
        "format": SET_FORMAT,
        "experiment": experiment,
        **({"title": title} if title else {}),
        "specimens": {name: dict(entry) for name, entry in specimens.items()},
        "columns": {name: {"unit": unit} for name, unit in units.items()},
        "noise": dict(noise or {}),
        "runs": {name: {**first, **given.get(name, {}), "file": files[name]} for name in frames},
    }
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "experiment.yaml")
        tables = {
            Path(folder, files[name]): one.to_csv(index=False) for name, one in frames.items()
        }
        write_files(tables | {path: yaml.safe_dump(plain(document), sort_keys=False)})
        try:
            loaded = load_measurements(path)
        except DocumentError as reason:
            raise DocumentError(_of_frames(str(reason), folder, files)) from None
    return Data(replace(loaded, folder=Path("frames")))


def _of_frames(message: str, folder: str, files: Mapping[str, str]) -> str:
    """A message about the files of a set, about the frames instead."""
    for name, file in files.items():
        message = message.replace(str(Path(folder, file)), f"frames[{name!r}]")
    document = re.escape(str(Path(folder, "experiment.yaml")))
    return re.sub(rf"{document}(:\d+)?: ", "", message)


def import_files(
    paths: Sequence[str | Path],
    experiment: str | None = None,
    columns: Mapping[str, tuple[str, str]] | None = None,
    hand: str | None = None,
    shifts: Mapping[str, float] | None = None,
    decimal: str = "",
    sheets: str | Mapping[str, str] = "",
    specimen: str | Mapping[str, str] | None = None,
    stretched_to: float | Mapping[str, float] | None = None,
    wrist: Sequence[float] | Mapping[str, Sequence[float]] | None = None,
    modes: str | Mapping[str, str] = "",
    split_restarts: bool = False,
    touched: str | float | None = None,
) -> Data:
    """A measurement set made of files as test rigs write them. Several files may hold one run,
    sampled at different rates.

    Args:
        paths: CSV files of any dialect, spreadsheets, MAT files, or bags.
        experiment: free_bending, blocked_tip, uniaxial, rubber, valve_pulse, base_torque,
            hand_pose, hand_motion, or, from bags of this suite, press or grasp; None: found out
            from the columns (of a hand: hand_pose).
        columns: for each quantity, the name of its column and the unit, such as {"pressure":
            ("P_reg", "psi")}; a unit of "" stands for the one in the header.
        hand: name of the hand, or HAND:ACTUATOR, to which the tested finger belongs; for files with
            marker positions and for bags of this suite, the hand that was recorded.
        shifts: time [s] to add to the clock of a file, by the name of the file.
        decimal: decimal sign of numbers in text files, "." or ","; "": found out from the file.
        sheets: sheet to read of spreadsheets with several sheets of numbers: one name for all
            files, or a name for each file by the name of the file; "": the only one.
        specimen: name of the specimen: one for all files, or one for each by the name of the file;
            None: taken from the file names.
        stretched_to: largest stretch [-] that the specimen had seen before the run: one number for
            all files, or one for each by the name of the file; None: not known.
        wrist: how the wrist of a hand was held, as roll, pitch and yaw [rad]: one triple for all
            files, or one for each by the name of the file; None: not stated.
        modes: how the rubber was stretched, uniaxial, pure_shear or equibiaxial: one mode for all
            files, or one for each by the name of the file; "": as the names of the files say.
        split_restarts: whether a new run begins where the clock of a file begins anew or
            pauses.
        touched: what the hand of a grasp touched, the name or file of the object on a table; of a
            press, the friction coefficient [-] of the level plate, at height 0; None for all other
            experiments.

    Raises ValueError if the files leave something open; the message says what, and how to state it.
    """
    from model_lab.importing.hand_contacts import Touched
    from model_lab.importing.hand_sets import set_of_hand
    from model_lab.importing.importing import make_set, propose
    from model_lab.measurements.hands import Grasped, Plate

    if decimal not in DECIMAL_SIGNS:
        raise ValueError(f"decimal: expected '.', ',' or '', got {decimal!r}")
    files = [Path(path) for path in paths]
    given = (None, decimal, _by_file(sheets))
    what: Touched | None = None
    if touched is not None:
        what = Grasped(touched) if isinstance(touched, str) else Plate(touched)
    of_hand = set_of_hand(files, hand, experiment, columns, shifts, *given, _by_file(wrist), what)
    if of_hand:
        found = of_hand[0]
    else:
        proposal = propose(files, experiment, columns, *given, _by_file(modes), split_restarts)
        before = _by_file(stretched_to)
        named = _by_file(specimen)
        found = make_set(proposal, hand, shifts, specimens=named, stretched_to=before)
    with tempfile.TemporaryDirectory() as folder:
        found.write(Path(folder))
        loaded = replace(load_measurements(folder), folder=Path("imported"))
    return Data(loaded, tuple(found.remarks))


def _by_file(said: T | Mapping[str, T] | None) -> dict[str, T]:
    """What is said of all files (under ""), or of each by its name."""
    if isinstance(said, Mapping):
        return dict(said)
    return {"": said} if said else {}


def synthesize(
    experiment: str, hide: str | None = None, seed: int = 0, noise: float = NOISE
) -> Data:
    """A simulated measurement set, to try the lab on: predictions of the base model with noise, and
    on request with one more effect, which `diagnose` should then find.

    Args:
        experiment: kind of the experiment, as in `from_frames`.
        hide: name of the effect to add; None: no effect.
        seed: seed of the random draws of specimens, effect parameters and noise.
        noise: standard deviation of the noise, as a share of the largest output [-].

    Raises ValueError for an unknown experiment or effect, and for an effect that this experiment
    cannot show.
    """
    known = effect_classes()
    if hide is not None and hide not in known:
        raise ValueError(f"hide: expected one of {', '.join(sorted(known))}, got {hide}")
    classes = {hide: known[hide]} if hide else None
    return Data(synthesised(experiment, seed, hide is not None, classes, noise).data)
