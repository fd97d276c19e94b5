"""Design of PneuFlex actuators: sizes, rubbers, fibres and casting moulds."""
