"""The explicit scheme: `central_difference`, its stable step, and the steps of a domain.

`state` holds the arrays and terms of a domain, and `body_view` shows one body of it. `serial_step` launches what a step
has beside the force pass; `stable_step` and `damped_step` estimate the largest step by Lanczos. On a GPU `device_step`
takes blocks of steps, with `device_boundary` and `device_contact` for boundary nodes; on several ranks `rank_state`
steps the part of a domain that one of them has, and `rank_view` shows whole bodies.
"""
