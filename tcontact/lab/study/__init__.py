"""Work-precision studies: methods x sizes x steps on problems with a reference, and the register of hard cases.

methods (what is compared), problems (scenes with a reference and errors), runner (the grid inside a budget), pareto,
table and figure (what is left in a folder), hard_cases (where a contact code can break).
"""
