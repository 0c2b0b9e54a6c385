// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/la_krylov/session.hpp"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <limits>
#include <string_view>
#include <thread>

#include <petscksp.h>
#include <unistd.h>

namespace drogue::la {

Result<Session> Session::start() {
  if (std::getenv("OMPI_COMM_WORLD_SIZE") == nullptr) setenv("OMPI_MCA_ess_singleton_isolated", "1", 0);
  if (PetscOptionsSetValue(nullptr, "-no_signal_handler", "true") != 0 || PetscInitializeNoArguments() != 0)
    return internal_error("PETSc does not start");
  PetscPushErrorHandler(PetscReturnErrorHandler, nullptr);
  return Session();
}

Session::~Session() {
  if (owner_) PetscFinalize();
}

bool started_on_ranks() {
  for (const char* variable : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"})
    if (const char* size = std::getenv(variable)) return std::string_view(size) != "1";
  return false;
}

int rank() {
  int r = 0;
  if (PetscInitializeCalled) MPI_Comm_rank(PETSC_COMM_WORLD, &r);
  return r;
}

int rank_count() {
  int n = 1;
  if (PetscInitializeCalled) MPI_Comm_size(PETSC_COMM_WORLD, &n);
  return n;
}

double sum_over_ranks(double value) {
  sum_over_ranks(&value, 1);
  return value;
}

void sum_over_ranks(double* values, int count) {
  if (rank_count() > 1) MPI_Allreduce(MPI_IN_PLACE, values, count, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
}

bool on_every_rank(bool value) {
  int all = value ? 1 : 0;
  if (rank_count() > 1) MPI_Allreduce(MPI_IN_PLACE, &all, 1, MPI_INT, MPI_MIN, PETSC_COMM_WORLD);
  return all != 0;
}

Result<void> agree(const Result<void>& own) {
  if (rank_count() == 1) return own;
  int first = own ? rank_count() : rank(); // the rank whose error counts
  MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPI_INT, MPI_MIN, PETSC_COMM_WORLD);
  if (first == rank_count()) return {};
  Error error = own ? Error{} : own.error();
  int head[3] = {static_cast<int>(error.kind), error.retryable ? 1 : 0,
                 static_cast<int>(error.message.size())};
  MPI_Bcast(head, 3, MPI_INT, first, PETSC_COMM_WORLD);
  error.message.resize(static_cast<std::size_t>(head[2]));
  MPI_Bcast(error.message.data(), head[2], MPI_CHAR, first, PETSC_COMM_WORLD);
  error.kind = static_cast<ErrorKind>(head[0]);
  error.retryable = head[1] != 0;
  return error;
}

std::vector<std::int64_t> process_ids() {
  std::vector<std::int64_t> ids(static_cast<std::size_t>(rank_count()));
  const std::int64_t own = getpid();
  ids.front() = own;
  if (ids.size() > 1) MPI_Allgather(&own, 1, MPI_INT64_T, ids.data(), 1, MPI_INT64_T, PETSC_COMM_WORLD);
  return ids;
}

void broadcast_passively(void* data, std::uint64_t bytes) {
  if (rank_count() == 1) return;
  auto* at = static_cast<char*>(data);
  while (bytes > 0) {
    const auto part = std::min<std::uint64_t>(bytes, std::numeric_limits<int>::max());
    MPI_Request request = MPI_REQUEST_NULL;
    MPI_Ibcast(at, static_cast<int>(part), MPI_BYTE, 0, PETSC_COMM_WORLD, &request);
    int done = 0;
    for (MPI_Test(&request, &done, MPI_STATUS_IGNORE); done == 0;
         MPI_Test(&request, &done, MPI_STATUS_IGNORE))
      std::this_thread::sleep_for(std::chrono::microseconds(200));
    at += part;
    bytes -= part;
  }
}

void broadcast_passively(std::vector<double>& values) {
  std::uint64_t size = values.size();
  broadcast_passively(&size, sizeof(size));
  values.resize(size);
  broadcast_passively(values.data(), size * sizeof(double));
}

void abort_all(int status) {
  MPI_Abort(PETSC_COMM_WORLD, status);
  std::abort();
}

} // namespace drogue::la
