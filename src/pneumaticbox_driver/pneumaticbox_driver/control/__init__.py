"""Control of the channels: one controller per mode."""
