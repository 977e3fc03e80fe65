"""The one module that imports the compiler of the kernels, Taichi, with the environment variables that it needs.

Whatever the caller has set stays. The variable TCONTACT_ENGINE names another compiler with the same language, such as
its fork Quadrants.
"""

import importlib
import os

HOME = os.path.expanduser("~")

os.environ.setdefault("TI_LOG_LEVEL", "error")
os.environ.setdefault("ENABLE_TAICHI_HEADER_PRINT", "0")
os.environ.setdefault("TI_SKIP_VERSION_CHECK", "ON")  # it would ask a server, and write into the home folder
os.environ.setdefault("HOME", HOME if os.path.isabs(HOME) else os.devnull)  # without one Taichi aborts the process

ti = importlib.import_module(os.environ.get("TCONTACT_ENGINE") or "taichi")
