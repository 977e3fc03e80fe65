"""What kernels are written in: tensors of scalars, lanes, bundles of arrays, options of the compiler."""
