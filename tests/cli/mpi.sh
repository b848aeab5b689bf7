# Shared by the tests of cvol-mpi; each sources it after lib.sh. It ends the test where processes cannot start.
# CVOL_MPIRUN is the launcher of the MPI library of this build, if that is not mpirun.
# shellcheck shell=sh disable=SC2034,SC2154
mpi=$CVOL_BUILD/cvol-mpi
if [ ! -x "$mpi" ] || ! command -v "${CVOL_MPIRUN:-mpirun}" >/dev/null 2>&1; then
    echo "skipped: no cvol-mpi or no ${CVOL_MPIRUN:-mpirun}"
    exit 0
fi
if [ -n "${CVOL_MPIRUN-}" ]; then
    mkdir "$top/launcher"
    printf '#!/bin/sh\nexec "%s" "$@"\n' "$(command -v "$CVOL_MPIRUN")" >"$top/launcher/mpirun"
    chmod +x "$top/launcher/mpirun"
    PATH=$top/launcher:$PATH
fi
# For Open MPI: in a container, as root, with more processes than cores, without ssh.
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_rmaps_base_oversubscribe=1
export OMPI_MCA_plm_rsh_agent=sh OMPI_MCA_btl_vader_single_copy_mechanism=none

if ! timeout 60 mpirun -n 2 true >/dev/null 2>&1; then
    echo 'skipped: mpirun cannot start two processes here'
    exit 0
fi

# many N COMMAND...: runs cvol-mpi by N processes.
many() {
    lib_processes=$1
    shift
    timeout 100 mpirun -n "$lib_processes" "$mpi" "$@"
}
