"""A script that imports the package alone, and asks for a contact that ranks share."""

import tcontact as tc

MESH = tc.box_mesh((0.1, 0.08, 0.1), (4, 4, 8))
BODY = tc.Body(MESH, tc.NeoHookean(2e7, 0.3, 1350.0), velocity=(0.0, 0.0, -5.0), contact="zmin")

result = tc.simulate(tc.Scene([BODY], [tc.Plane((0.0, 0.0, -1e-4))], 5e-4), threads=1, contact_ranks=2)
if tc.is_first_rank():
    print(result.reason)
