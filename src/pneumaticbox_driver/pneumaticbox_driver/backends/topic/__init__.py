"""The box's plant on topics: the simulator, or another node that owns valves and sensors."""
