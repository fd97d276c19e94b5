"""Hidden effects of hands in motion: sets made by MuJoCo's hand, judged by the lab."""
