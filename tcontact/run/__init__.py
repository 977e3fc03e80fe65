"""Runs: from the call of the user to the result.

How it works. `simulation.simulate` checks its input, plans, starts the device and runs the `loop`, which takes one step
after the other and keeps a row of `history` for each. `guards` look at every row; `watches` look between launches for
what rows do not show. `recorder` writes frames, `checkpoint` writes what `resumption.resume` continues from,
`scene_files` reads and writes scenes as TOML. `watched` is the part of a run that watches and checkpoints see.
"""
