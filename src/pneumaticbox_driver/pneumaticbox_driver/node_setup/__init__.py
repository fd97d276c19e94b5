"""What the node does first: declare its parameters and choose its clock."""
