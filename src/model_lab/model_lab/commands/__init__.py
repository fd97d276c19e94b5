"""The subcommands of `model-lab`, one file each: `add_to` declares one, `run` carries it out."""
