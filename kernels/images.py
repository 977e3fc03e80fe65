"""Images of one degree of freedom on opposite sides of a periodic body (tcontact/periodic.py).

    F_master = sum of the images' F,   u_image = u_master,  v_image = v_master

`images`: flat pairs (follower, master) of places in the list of boundary nodes, ascending by the master. A follower has
no mass, no load and after `gather` no force: sums over the boundary nodes count every degree of freedom once.
"""

import taichi as ti


@ti.func
def gather(special_force: ti.template(), images: ti.template()):
    """The forces of the followers go to their masters."""
    for i in range(images.shape[0] // 2):
        follower, master = images[2 * i], images[2 * i + 1]
        for j in ti.static(range(3)):
            special_force[3 * master + j] = special_force[3 * master + j] + special_force[3 * follower + j]
            special_force[3 * follower + j] = 0.0


@ti.func
def follow(values: ti.template(), nodes: ti.template(), images: ti.template(), masters):
    """Values [n, 3] of the nodes: every follower of the first boundary nodes, `masters` of them, takes its master's."""
    i = 0
    while i < images.shape[0] // 2 and images[2 * i + 1] < masters:
        follower, master = nodes[images[2 * i]], nodes[images[2 * i + 1]]
        for j in ti.static(range(3)):
            values[3 * follower + j] = values[3 * master + j]
        i += 1
