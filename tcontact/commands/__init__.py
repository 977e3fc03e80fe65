"""The commands of the program, one file each: `add` declares its arguments, `run` does it and returns the exit code.

How it works. `cli` collects the commands and turns an `InputError` into a message and exit code 2. `settings` reads
KEY=VALUE pairs by the annotations of the case's `scene`, `words` the other options; `folder` knows which files the
program wrote, so that no other run is overwritten and `--force` removes nothing else.
"""
