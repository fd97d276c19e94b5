"""Hidden effects of whole hands: sets made by the simulator at rest, judged by the lab."""
