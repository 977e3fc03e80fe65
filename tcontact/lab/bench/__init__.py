"""The benchmark behind `tcontact bench`: every configuration in a process of its own, every speed with its errors.

How it works. `configuration` names what is measured (cells, law, size, contact), `worker` runs one in a fresh
process, `measure` times rounds of steps beside `plain_step`, the obvious kernel with atomics, and `accuracy` and
`reference` compare the forces with numpy and run the same scene for its energy error. `alternatives` times the force
beside what a user could take instead, `waiting` what is no step. `collect`, `table` and `chart`
put it together: compile time is a column of its own, and what fails gets a row.
"""
