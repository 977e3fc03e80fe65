"""The explicit scheme: `central_difference`, its stable step, and the steps of the domains.

`state` holds the arrays and terms of a domain, `serial_step` does all of a step but the force pass, `stable_step`
and `damped_step` estimate the largest step by Lanczos.
"""
