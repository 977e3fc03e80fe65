"""The commands, one module each: `add(subparsers)` declares it, `run(arguments)` returns the exit code."""
