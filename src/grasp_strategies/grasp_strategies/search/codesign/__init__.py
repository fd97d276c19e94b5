"""Hand and motion searched together: their numbers, what a grasp is worth, equal budgets."""
