"""The language of the kernels: tensors of scalars, vectors of lanes, bundles of arrays, options of the compiler."""
