"""Results: what comes out of a run, how it is judged and reported, and its files.

How it works. `result.Result` holds the end of a run and its history. `checks` compare it with bounds, `exact` has
solutions in closed form, `smoothness` measures its contact pressure. `report` writes summary.json, history.csv and the
table at the end; `frame_fields`, `exporting` and `files` make, read and write frames.
"""
