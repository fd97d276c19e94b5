"""The command `model-lab`: its subcommands and the options that they share."""
