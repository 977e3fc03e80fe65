"""Ranks that do not do the same: `mpiexec -n P python rank_lone.py RANK MOMENT [FOLDER]`.

before: the rank fails before it starts a run, which the others wait for; after: when the others are at their end;
everyone: all ranks fail, this one with an error of its own; idle: the rank starts no run; scene: it has another scene;
load: another gravity; out: it alone names the folder; step: it has another scheme. While the ranks compare the scene,
exits: the rank leaves Python; resume: the same, of a run that goes on; stopped: it gets the signal of Ctrl-C.
"""

import os
import signal
import sys

from rank_scenes import block

import tcontact as tc
from tcontact.device import ranks

own, moment, folder = ranks.launched()[1] == int(sys.argv[1]), sys.argv[2], sys.argv[3:]
if moment == "everyone":
    raise tc.InputError("size", -2 if own else -1, "all ranks have an error")
if moment == "before" and own:
    raise tc.InputError("size", -1, "this rank alone")
speed = 3.0 if moment == "scene" and own else 2.0
pull = 3.0 if moment == "load" and own else 2.0
ready = []  # once the scene is made


def gravity(t):
    """Return the gravity, or end this rank."""
    if ready and own and moment in ("exits", "resume"):
        sys.exit(3)
    if ready and own and moment == "stopped":
        os.kill(os.getpid(), signal.SIGINT)
    return 0.0, 0.0, pull * t


scene = tc.Scene([block(velocity=(0.0, 0.0, speed))], duration=1e-4, gravity=gravity)
ready.append(True)
if moment == "resume":
    tc.resume(folder[0], scene)
options = {"out": folder[0], "frames": 2} if folder and (own or moment != "out") else {"frames": 2}
if not (moment == "idle" and own):
    tc.simulate(scene, tc.CentralDifference(cfl=0.5 if moment == "step" and own else 0.6), threads=1, **options)
if moment == "after" and own:
    raise ValueError("this rank alone")
