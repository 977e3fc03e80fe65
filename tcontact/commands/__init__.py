"""The commands of the program, one file each: `add` declares its arguments, `run` does it and returns the exit code.

How it works. `cli.py` collects the commands and turns an `InputError` into a message and exit code 2. `settings`
reads KEY=VALUE pairs by the annotations of the case's `scene`, `words` the other options; `folder` knows which files
are ours, so that another run is never overwritten and `--force` removes nothing else.
"""
