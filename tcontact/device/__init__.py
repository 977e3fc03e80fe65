"""The device: Taichi's runtime, arrays on a processor or a GPU, launches, and files that survive a crash.

How it works. `runtime.start` is the one place that starts Taichi. `arrays` are NumPy memory on a processor and Taichi's
on a GPU; a kernel that is launched often is prepared once (`launch`); `tracing` makes compiling faster. `ranks`
finds the processes that mpiexec has started, `exchange` adds values at nodes that several of them have, and `lead` lets
the first one do alone what reads whole bodies.
"""
