"""The commands `softhand hand design`, `softhand hand mould` and `softhand materials`."""
