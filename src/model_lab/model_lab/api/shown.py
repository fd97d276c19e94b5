"""How results show themselves: as text on a terminal, with figures and tables in a notebook."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import replace
from itertools import count
from typing import TYPE_CHECKING

from matplotlib.figure import Figure

from model_lab.report.drawing import PICTURE_WIDTH, Drawing, legend_above, paint, styled
from model_lab.report.page import template

if TYPE_CHECKING:
    from model_lab.report.tables import Table

COLUMNS = 3  # of panels
ROW_HEIGHT = 2.4  # [in] of a row of panels
_numbers = count()  # of figures: the ids of a notebook must differ


class Shown(ABC):
    """A result that prints itself."""

    @abstractmethod
    def text(self) -> str:
        """The text that `print` shows."""

    def drawings(self) -> list[Drawing]:
        """The figures that a notebook shows."""
        return []

    def tables(self) -> list[Table]:
        """The tables that a notebook shows."""
        return []

    def headline(self) -> str:
        """The text that a notebook shows above figures and tables."""
        return self.text()

    def __repr__(self) -> str:
        return self.text().rstrip("\n")

    def _repr_html_(self) -> str:
        drawings = [replace(one, name=f"{one.name}-{next(_numbers)}") for one in self.drawings()]
        return template("notebook.html").render(
            headline=self.headline(), drawings=drawings, contents=self.tables(), text=self.text()
        )


def figure_of(*drawings: Drawing) -> Figure:
    """One matplotlib figure with the panels of all drawings, as a notebook shows it."""
    panels = [panel for drawing in drawings for panel in drawing.panels]
    keys = {key.text: key for drawing in drawings for key in drawing.keys}
    rows = -(-len(panels) // COLUMNS)
    with styled():
        figure = Figure(figsize=(PICTURE_WIDTH, ROW_HEIGHT * rows + 0.4), layout="constrained")
        paint(figure, panels, COLUMNS)
        if keys:
            legend_above(figure, tuple(keys.values()))
    return figure
