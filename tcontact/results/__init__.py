"""What comes out of a run: the result, what is judged and reported of it, and its files.

How it works. `result.Result` holds the end of a run and its history. `checks` compare it with bounds, `exact` with
closed forms, `smoothness` measures its contact pressure. `report` writes summary.json, history.csv and the table at the
end; `exporting` and `files` read and write frames.
"""
