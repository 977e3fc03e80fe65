"""The one module that imports the compiler of the kernels, Taichi.

The environment variable TCONTACT_ENGINE names another one with the same language, such as its fork Quadrants.
"""

import importlib
import os

ti = importlib.import_module(os.environ.get("TCONTACT_ENGINE") or "taichi")
