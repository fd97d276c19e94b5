"""The tab `Lab`: dropped measurements, what their columns are, which effect is missing, and the
hand with it. It runs the commands of `model-lab`, and never commands hardware.
"""

from __future__ import annotations

import argparse
import html
import shlex
import tempfile
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import TypeVar

import viser

from model_lab.cli.options import DECIMAL_SIGNS, attitude, column_map, name_of_file, stretch_before
from model_lab.importing.cells import Ambiguous
from model_lab.importing.derived_columns import Maps
from model_lab.importing.hand_sets import set_of_hand
from model_lab.importing.importing import ImportedSet, Proposal, make_set, propose
from model_lab.importing.tables import read_tables
from model_lab.importing.told import table_rows
from model_lab.measurements.hands import HAND_POSE
from model_lab.report.first_look_text import FIRST_LOOK
from softhand_common.documents.json_document import read_json
from softhand_model.hand.hand import hand_names, load_hand
from softhand_play.lab_process import LabProcess
from softhand_play.messages import Look
from softhand_play.page_context import PageContext
from softhand_play.widgets import NOTHING, offer

T = TypeVar("T")
AS_SHOWN = "as the numbers show"
NO_HAND = "unknown: a straight line as model"
LINEAR, BASE = "linear", "base"
FILES_LIMIT = 50  # files of one set
SIZE_LIMIT = 50_000_000  # [bytes] of a file
STYLE = "margin: 0.4em 0.8em; font-size: 0.72em; overflow-x: auto; max-height: 26em"


class LabTab:
    """The tab that makes a model for the hand from dropped files of measurements."""

    def __init__(self, page: PageContext, tab: viser.GuiTabHandle) -> None:
        self._page, gui = page, page.server.gui
        self._folder = tempfile.TemporaryDirectory(prefix="softhand-play-")
        self._set, self._out = (Path(self._folder.name) / name for name in ("set", "results"))
        self._out.mkdir()
        self._files: list[Path] = []
        self._is_set = False
        self._count = 0  # of models that were added
        self.work = LabProcess(self._told)
        with tab:
            gui.add_markdown("Open or drop CSV or spreadsheet files: all runs of one experiment.")
            self.finger = gui.add_dropdown(
                "measured finger or hand", (NO_HAND, *_fingers(), *_hands())
            )
            self.maps = gui.add_text(
                "columns",
                "",
                hint="what the names do not say: NAME=COLUMN:UNIT, several with spaces between; "
                "'...' around a text with spaces",
            )
            with gui.add_folder("more about the files", expand_by_default=False):
                self.decimal = gui.add_dropdown("decimal sign", (AS_SHOWN, *DECIMAL_SIGNS))
                self.sheet = gui.add_text(
                    "sheet", "", hint="of a spreadsheet; of single files FILE=SHEET; FILE=SHEET"
                )
                self.specimen = gui.add_text(
                    "specimen",
                    "",
                    hint="of all files, or of single ones FILE=NAME; empty: as their names say",
                )
                self.stretched = gui.add_text(
                    "stretched to",
                    "",
                    hint="largest stretch before the run, 1 for none; of single files A=1.5; B=2",
                )
                self.wrist = gui.add_text(
                    "wrist of a hand",
                    "",
                    hint="ROLL,PITCH,YAW in degrees; of single files A=0,90,0; B=0,0,0",
                )
            self._columns = gui.add_html("")
            compare = gui.add_button("compare", hint="checks the data first, then the model")
            diagnose = gui.add_button("diagnose", hint="names the effect that is missing")
            cancel = gui.add_button("cancel")
            self.effect = gui.add_dropdown("missing effect", NOTHING)
            add = gui.add_button("add it, and move the hand with it")
            forget = gui.add_button("forget these files")
            self._answer = gui.add_html("")
        more = (self.decimal, self.sheet, self.specimen, self.stretched, self.wrist)
        for widget in (self.finger, self.maps, *more):
            widget.on_update(lambda _: page.attempt(self._look))
        compare.on_click(lambda _: page.attempt(self._compare))
        diagnose.on_click(lambda _: page.attempt(self._diagnose))
        cancel.on_click(lambda _: page.attempt(self._cancel))
        add.on_click(lambda _: page.attempt(self._add))
        forget.on_click(lambda _: page.attempt(self._forget))

    # ---------------------------------------------------------------- files
    def take(self, path: Path) -> None:
        """Take one more file. Raises ValueError for a file that cannot be read, which is left out,
        and for one that can be read in two ways, which is kept until the user says how to read it.
        """
        if len(self._files) >= FILES_LIMIT:
            raise ValueError(f"{path.name}: expected at most {FILES_LIMIT} files, got one more")
        size = path.stat().st_size
        if size > SIZE_LIMIT:
            most = f"{SIZE_LIMIT / 1e6:g} MB of measurements"
            raise ValueError(f"{path.name}: expected at most {most}, got {size / 1e6:.0f} MB")
        with suppress(Ambiguous):
            if self.finger.value in _hands():
                read_tables(path)
            else:
                self._proposal([path], {})
        self._files.append(path)
        self._look()

    def _look(self) -> None:
        """Show what the columns are, and make the set; raises ValueError for what is open."""
        self._cancel()
        self._is_set = False
        if not self._files:
            return
        proposal, made = self._read()
        for old in self._set.glob("*"):
            old.unlink()
        made.write(self._set)
        self._is_set = True
        self._page.report(
            "; ".join((f"{proposal.experiment}, {len(made.runs)} runs", *made.remarks)),
            Look.SUCCESS,
        )

    def _read(self) -> tuple[Proposal, ImportedSet]:
        """What the files hold, which is shown, and their set."""
        hand, maps = self.finger.value, self._given_maps()
        if hand in _hands():
            held = _said(self.wrist, attitude)
            read = (
                None,
                DECIMAL_SIGNS.get(self.decimal.value, ""),
                _said(self.sheet, name_of_file),
            )
            of_hand = set_of_hand(self._files, hand, HAND_POSE, maps, None, *read, held)
            if of_hand is not None:
                self._columns.content = _table(table_rows(of_hand[1]))
                return of_hand[1], of_hand[0]
        proposal = self._proposal(self._files, maps)
        self._columns.content = _table(table_rows(proposal))
        return proposal, make_set(
            proposal,
            None if hand == NO_HAND else hand,
            specimens=_said(self.specimen, name_of_file),
            stretched_to=_said(self.stretched, stretch_before),
        )

    def _proposal(self, files: Sequence[Path], maps: Maps) -> Proposal:
        named = {path.name for path in files}
        sheets = {
            file: sheet
            for file, sheet in _said(self.sheet, name_of_file).items()
            if not file or file in named
        }
        decimal = DECIMAL_SIGNS.get(self.decimal.value, "")
        return propose(files, None, maps, None, decimal, sheets)

    def _given_maps(self) -> Maps:
        try:
            words = shlex.split(self.maps.value)  # as in a terminal, from which it may be pasted
            return dict(column_map(word) for word in words if word != "--map")
        except (argparse.ArgumentTypeError, ValueError) as reason:
            raise ValueError(f"columns: {reason}") from reason

    def _forget(self) -> None:
        self._cancel()
        self._files, self._is_set = [], False
        self._columns.content = self._answer.content = ""
        offer(self.effect, ())

    # ---------------------------------------------------------------- the lab
    @property
    def _model(self) -> str:
        return LINEAR if self.finger.value == NO_HAND else BASE

    def _compare(self) -> None:
        words = ["compare", str(self._set), "--model", self._model]
        self._run(words, lambda text: self._show(text, "compared; the answer is in the tab Lab"))

    def _diagnose(self) -> None:
        found = self._out / "diagnosis.json"
        words = ["diagnose", str(self._set), "--model", self._model, "--json", str(found)]

        def done(text: str) -> None:
            answer = read_json(found).mapping()
            names = [effect.mapping()["name"].value for effect in answer["effects"].items()]
            offer(self.effect, tuple(names))
            self._show(
                text, f"verdict: {answer['verdict'].value}: {', '.join(names) or 'no effect'}"
            )

        self._run([*words, "--force"], done)

    def _add(self) -> None:
        if self.effect.value in NOTHING:
            raise ValueError(
                "missing effect: expected a diagnosed one, got none; press diagnose first"
            )
        self._count += 1
        effect, model = self.effect.value, self._out / f"model_{self._count}.yaml"
        words = ["add", effect, "--data", str(self._set), "--model", self._model]

        def done(text: str) -> None:
            self._show(text, f"{effect} is added; the hand moves with it")
            player = self._page.player
            player.play(
                replace(player.world, settings=replace(player.world.settings, model=str(model)))
            )

        self._run([*words, "--out", str(model)], done)

    def _run(self, words: Sequence[str], done: Callable[[str], None]) -> None:
        """Run a command; its answer is shown, or its error."""
        if not self._is_set:
            raise ValueError(
                "lab: no measurements yet; drag files onto the page, and answer its questions"
            )

        def ended(code: int, text: str) -> None:
            if code:
                self._page.report(text or f"model-lab {words[0]}: ended with {code}", Look.ERROR)
            else:
                self._page.attempt(lambda: done(text))

        self.work.start(words, ended)
        self._page.report(f"{words[0]}: computing; the page can be used in the meantime")

    def _told(self, line: str) -> None:
        """Show a line of progress; the first look stays until the answer comes."""
        if line.startswith(FIRST_LOOK):
            self._show_text(line)
        self._page.report(line)

    def _show(self, text: str, sentence: str) -> None:
        self._show_text(text)
        self._page.report(sentence, Look.SUCCESS)

    def _show_text(self, text: str) -> None:
        shown = text.replace(self._folder.name, "...")
        self._answer.content = f'<pre style="{STYLE}">{html.escape(shown)}</pre>'

    def _cancel(self) -> None:
        if self.work.is_running:
            self.work.cancel()
            self._page.report("cancelled")

    def close(self) -> None:
        """End a running command."""
        self.work.cancel()


def _said(field: viser.GuiInputHandle[str], read: Callable[[str], tuple[str, T]]) -> dict[str, T]:
    """What a field says of files, by their names; raises ValueError with what it expects."""
    try:
        return dict(read(word.strip()) for word in field.value.split(";") if word.strip())
    except argparse.ArgumentTypeError as reason:
        raise ValueError(f"{field.label}: {reason}") from reason


def _fingers() -> list[str]:
    """HAND:FINGER of the shipped hands, for chains of a single actuator."""
    return [
        f"{name}:{chain.name}"
        for name in hand_names()
        for chain in load_hand(name).chains
        if len(chain.actuators) == 1 and not chain.turn
    ]


@cache
def _hands() -> tuple[str, ...]:
    """The shipped hands with several fingers."""
    return tuple(name for name in hand_names() if len(load_hand(name).tips) > 1)


def _table(rows: Sequence[Sequence[str]]) -> str:
    lines = (
        "<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>" for row in rows
    )
    return f'<div style="{STYLE}"><table>{"".join(lines)}</table></div>'
