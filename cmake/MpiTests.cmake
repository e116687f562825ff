# SPDX-License-Identifier: Apache-2.0

# The environment of tests that run by mpirun. Open MPI may run as root, and with more ranks than cores; it
# must not bind ranks to cores, since other tests run too, and not use calls that containers forbid. Leaks are
# not checked, since Open MPI itself leaks.
set(ESPALIER_MPI_ENVIRONMENT
  OMPI_ALLOW_RUN_AS_ROOT=1
  OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
  OMPI_MCA_rmaps_base_oversubscribe=1
  OMPI_MCA_hwloc_base_binding_policy=none
  OMPI_MCA_mpi_yield_when_idle=1
  OMPI_MCA_btl_vader_single_copy_mechanism=none
  ASAN_OPTIONS=detect_leaks=0)
