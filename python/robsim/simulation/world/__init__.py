"""The simulated world: its scene, disturbances and dropouts."""
