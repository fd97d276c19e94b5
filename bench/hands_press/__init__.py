"""Hidden effects of hands that are pressed on a plate: sets made by MuJoCo, judged by the lab."""
