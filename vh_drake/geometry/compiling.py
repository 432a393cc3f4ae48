"""How compiled arithmetic is compiled."""

from numba import njit

# For kernels that allocate nothing: without reference counts of the arrays that they are given,
# which would cost more than the work itself.
bare_njit = njit(cache=True, _nrt=False)
