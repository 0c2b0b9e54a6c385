# SPDX-License-Identifier: GPL-3.0-or-later
# Sourced by the scripts: the repository's root, the environment of the executables, and how scripts speak.

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)

# How many jobs to run side by side. nproc would take OMP_NUM_THREADS for the number of processors.
jobs=${JOBS:-$(env -u OMP_NUM_THREADS nproc)}

# One thread in BLAS unless the user asks for more: the processes of a coupled run share the cores.
export OPENBLAS_NUM_THREADS=${OPENBLAS_NUM_THREADS:-1}
export OMP_NUM_THREADS=${OMP_NUM_THREADS:-1}
# Open MPI: run as root in containers, start single processes without a daemon.
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_ess_singleton_isolated=1

# Debian's Python: the one that sees Debian's VTK, meshio, ZeroMQ and Protobuf packages.
python=/usr/bin/python3

headline() { printf '\n==> %s\n' "$*" >&2; }
say() { printf '    %s\n' "$*" >&2; }
die() {
  printf '%s: %s\n' "$(basename "$0")" "$*" >&2
  exit 2
}

# The comment block at the top of the calling script, without the licence line and comment signs.
usage() { sed -n '3,/^[^#]/{/^#/s/^# \{0,1\}//p}' "$0"; }

show_help_if_asked() {
  case ${1:-} in -h | --help) usage && exit 0 ;; esac
}
