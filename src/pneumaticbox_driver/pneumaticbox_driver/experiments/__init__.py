"""Experiments of chapter 4 on the pretended bench, one command each: `pneumatics-experiment`.

A module of `catalogue.EXPERIMENTS` holds `SENTENCE` (what it shows), `THESIS` (where it stands
there), `Settings` (its options), and three steps that know nothing of each other: `simulate`
returns series, `report` figures and a verdict from series, `draw` a picture of series and report.
The box is the real one; the plant, which it does not know, is the truth.
"""
