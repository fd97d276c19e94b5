"""Many grasps in process: trials, sweeps, success maps and searches."""
