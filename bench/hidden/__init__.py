"""Measurement sets with hidden effects, generated independently of the project's own physics.

Nothing here imports the project: every equation is written anew, solved by continuation in time on
a finer grid than the samples that are written, so that the lab is never tested on data from its own
code. `make_set` writes a folder in the layout softhand-measurement/1 and returns the truth, which
the folder does not hold.
"""

from bench.hidden.sets.driven import make_set

__all__ = ["make_set"]
