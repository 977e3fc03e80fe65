"""A script whose scene takes one rank."""

import tcontact as tc

body = tc.Body(tc.box_mesh((1.0, 1.0, 1.0), (3, 3, 3)), tc.LinearElastic(1e6, 0.3, 1e3))
tc.simulate(tc.Scene([body], duration=1e-3), tc.DiscreteGradient(dt=1e-5))
