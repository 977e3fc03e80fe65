"""Tools that all kernels are written with: 3x3 tensors, lanes, bundles of arrays, compiler options."""
