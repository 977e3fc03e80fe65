"""The explicit scheme: `central_difference`, its stable step, and the steps of a domain.

`state` holds the arrays and terms of a domain, and `body_view` shows one body of it. `serial_step` launches what a step
has beside the force pass; `stable_step` and `damped_step` estimate the largest step by Lanczos.
"""
