# Shared by the tests of several processes, after lib.sh. CVOL_MPIRUN is the launcher of the MPI library that the build
# uses (default mpirun). The test ends here if it cannot start two processes.
# shellcheck shell=sh disable=SC1091,SC2034,SC2154
. "${0%/*}/lib.sh"

mpi=$CVOL_BUILD/cvol-mpi
launcher=${CVOL_MPIRUN:-mpirun}
if [ ! -x "$mpi" ] || ! command -v "$launcher" >/dev/null 2>&1; then
    echo "skipped: no cvol-mpi or no $launcher"
    exit 0
fi
# For Open MPI: in a container, as root, with more processes than cores, without ssh.
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_rmaps_base_oversubscribe=1
export OMPI_MCA_plm_rsh_agent=sh OMPI_MCA_btl_vader_single_copy_mechanism=none

if ! timeout 60 "$launcher" -n 2 true >/dev/null 2>&1; then
    echo "skipped: $launcher cannot start two processes here"
    exit 0
fi
