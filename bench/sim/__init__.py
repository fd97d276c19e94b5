"""The simulator measured: speed, robustness and what the step does to a grasp.

Every module of this folder with a function `rows(small: bool) -> list[dict]` is a group of rows
(see `bench.row` for their keys); it takes part by being there.
"""
