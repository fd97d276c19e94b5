"""Judging of a grasp: its verdict, the cause of a failure, and when a trial can end early."""
