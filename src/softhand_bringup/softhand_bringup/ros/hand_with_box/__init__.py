"""The nodes `hand_sim` and `pneumaticbox` in one process."""
