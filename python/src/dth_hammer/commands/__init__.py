"""The subcommands of `dth-hammer`, one module each, imported when it is chosen.

The module of a command has these parts:

* ``run(options)`` does the work, prints, and returns the result for ``--json``. A command whose
  ``run`` returns None has no such option.
* ``CALL`` is the function whose arguments become the command's options.
* ``ALSO`` lists further options, if there are any.
* ``NEEDS`` lists the optional packages that the command always needs, if there are any.

`dth_hammer.cli` checks that output files can be written, prints errors and handles interrupts. To
add a command, write its module and add its name to `COMMANDS`.
"""

#: Commands in the order of the help text: the name, which is also the module's, and a description.
COMMANDS = {
    "demo": "simulate the reference hammer, print its numbers, draw its settled cycle",
    "run": "simulate one hammer over time",
    "steady": "compute the long-run response of hammers, periodic or not, with errors",
    "trend": "compute what the long-run response depends on, with errors and roughness",
    "calibrate": "estimate parameters from measured means, with errors",
    "optimise": "find the parameters, within bounds and limits, for which a mean is largest",
    "waves": "compute stresses along piston and bit, or write an FMU that does",
    "life": "compute the fatigue life of piston and bit from an S-N line",
    "sweep": "simulate a grid of hammers",
    "report": "write a run as one HTML page with figures, tables and settings",
    "fmu": "copy the FMUs of the hammer to a folder",
    "configure": "write an FMU that starts with your parameters, for hosts that cannot set them",
    "system": "write an .ssp of the hammer and its drive, connected by name",
    "mesh": "print the mesh that a stated error needs",
    "datasheet": "find the hammer that a datasheet or a catalogue describes, and report on it",
    "compare": "compare two hammers, or one at two pressures, in one rock",
    "log": "find the rock's specific energy over depth from a drilling log",
    "rock": "list rocks, with sources and scatter, or print the parameters of one under a bit",
    "info": "list presets and groups of variables, or one group or variable with units and domains",
}
