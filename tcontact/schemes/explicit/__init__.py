"""The explicit scheme: `central_difference`, its stable step, and the steps of the bodies.

`state` holds the arrays and terms of a body, `serial_step` does what a step has beside the force pass, `stable_step`
and `damped_step` estimate the largest step by Lanczos.
"""
