"""Spoils what is computed behind the back of whoever judges it: a check that is worth its name must fail then.

`Spoilt(change)` stands in for `tcontact.simulate`: it runs the scene with one change and returns the result as if it
were of the scene that was asked for.
"""

from dataclasses import fields, replace

import numpy as np

import tcontact as tc


def without_wall(scene):
    """Every plane a thousand lengths away."""
    if not scene.obstacles:
        return scene
    size = max(float(np.ptp(body.mesh.nodes, axis=0).max()) for body in scene.bodies)
    far = []
    for wall in scene.obstacles:
        place = "point" if hasattr(wall, "point") else "center"
        way = -1e3 if place == "point" else 1e3
        far.append(replace(wall, **{place: tuple(np.asarray(getattr(wall, place)) + way * size * wall.frame[2])}))
    return replace(scene, obstacles=far)


def with_material(scene, share, *names):
    """Named constants of every material times a share, whichever of them it has."""

    def altered(material):
        known = {item.name for item in fields(material)}
        return replace(material, **{name: share * getattr(material, name) for name in names if name in known})

    def altered_all(material):
        several = isinstance(material, dict)
        return {name: altered(one) for name, one in material.items()} if several else altered(material)

    return replace(scene, bodies=[replace(body, material=altered_all(body.material)) for body in scene.bodies])


def turned_gravity(scene):
    """Gravity upside down."""
    return scene if scene.gravity is None else replace(scene, gravity=tuple(-np.asarray(scene.gravity)))


def less_friction(scene):
    """Half of the coefficient, of pairs of bodies too."""

    def half(law):
        return None if law is None else replace(law, coefficient=0.5 * law.coefficient)

    if scene.friction is None:
        return scene
    pairs = scene.pairs
    if isinstance(pairs, tuple):
        pairs = [replace(pair, friction=half(pair.friction)) for pair in pairs]
    return replace(scene, friction=half(scene.friction), pairs=pairs)


CHANGES = {
    "wall": without_wall,
    "method": lambda scene: replace(scene, contact=tc.ImpulseContact()),
    "modulus": lambda scene: with_material(scene, 0.7, "young", "c1", "c2", "bulk"),
    "density": lambda scene: with_material(scene, 1.3, "density"),
    "duration": lambda scene: replace(scene, duration=0.5 * scene.duration),
    "gravity": turned_gravity,
    "friction": less_friction,
}


class Spoilt:
    """`tcontact.simulate` with one of CHANGES; altered: whether it has changed any scene so far."""

    def __init__(self, change):
        self.change, self.run, self.altered = CHANGES[change], tc.simulate, False

    def __call__(self, scene, *arguments, **options):
        """Run the changed scene; the result says that it is of the scene given."""
        other = self.change(scene)
        self.altered |= other is not scene
        return replace(self.run(other, *arguments, **options), scene=scene)
