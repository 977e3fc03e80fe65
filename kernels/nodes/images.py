"""Periodic images: nodes on opposite sides of a periodic body that move as one (tcontact/scene/periodic.py).

    F_master = sum of the images' F,   u_image = u_master,  v_image = v_master

`images`: flat pairs (follower, master) of places in the list of boundary nodes. A follower has no mass, no load and
after `gather` no force, so that sums over the boundary nodes count every degree of freedom once.
"""

from ..engine import ti


@ti.func
def gather(special_force: ti.template(), images: ti.template()):
    """Add the forces of the followers to those of their masters, and set them to 0."""
    for i in range(images.shape[0] // 2):
        follower, master = images[2 * i], images[2 * i + 1]
        for j in ti.static(range(3)):
            special_force[3 * master + j] = special_force[3 * master + j] + special_force[3 * follower + j]
            special_force[3 * follower + j] = 0.0


@ti.func
def follow(u: ti.template(), v: ti.template(), nodes: ti.template(), images: ti.template()):
    """Set displacement and velocity of the followers to those of their masters; nodes [s]: the boundary nodes."""
    for i in range(images.shape[0] // 2):
        follower, master = nodes[images[2 * i]], nodes[images[2 * i + 1]]
        for j in ti.static(range(3)):
            u[3 * follower + j] = u[3 * master + j]
            v[3 * follower + j] = v[3 * master + j]
