"""The figures that README.md and docs/NUMBERS.md state, and how each of them is made again.

`register` names the command and the place in its report for every figure; `reports` runs the commands; `tables` writes
the Markdown; `pages` finds the tables in the documents and compares or replaces them; `pictures` draws the pictures of
the documents. `tcontact numbers` is the command.
"""
