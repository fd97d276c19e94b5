"""Co-design of hand and motion (5.1, 6.5, 9.2, 10.2): arms, worlds, budget, evaluation."""
