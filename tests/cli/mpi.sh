# Shared by the tests of cvol-mpi; each sources it after lib.sh. It ends the test where processes cannot start.
# shellcheck shell=sh disable=SC2154
mpi=$CVOL_BUILD/cvol-mpi
if [ ! -x "$mpi" ] || ! command -v mpirun >/dev/null 2>&1; then
    echo 'skipped: no cvol-mpi or no mpirun'
    exit 0
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
