"""Colours of the figures: Okabe and Ito's, told apart by colour-blind readers too."""

TARGET = "#333333"
FULL = "#0072B2"  # the full model, own calibration, ours
OTHER = "#D55E00"  # the baseline, the shared calibration
SUPPLY = "#009E73"
THESIS_LINE = "#8A8A8A"  # the thesis's numbers
CHANNELS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#333333", "#B8A800")
