"""Work-precision studies: methods x sizes x steps on problems with a reference, and the register of hard cases.

How it works. `methods` are what is compared, `problems` the scenes with a reference and errors; `runner` runs the grid
of methods, sizes and steps inside a budget of time; `pareto`, `table` and `figure` write what it finds into a folder.
`hard_cases` are the places where a contact code can break, collected in `hard_register`.
"""
