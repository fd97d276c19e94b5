"""The experiments by which the thesis checks its model and simulator (sections 3.4 and 5.2), made
again: one file each, one command for all, `pneuflex-validate`.
"""
