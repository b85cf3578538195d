"""Everything that defines a run: variables, units, parameters, rocks, meshes, inputs over time."""
