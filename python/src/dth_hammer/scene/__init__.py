"""What a run starts from: names, units, parameters, rocks, meshes, inputs over time."""
