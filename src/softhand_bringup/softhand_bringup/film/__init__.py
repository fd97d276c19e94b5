"""Films of grasps: a trial in process or a bag, as pictures, GIF or MP4."""
