"""Hidden effects of hands that grasp: sets made by another engine, judged by the lab."""
