// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include "common/base/result.hpp"

namespace drogue::la {

/// PETSc and MPI for the lifetime of the object; one in a process, created by main(). Signals stay with the
/// program. Started outside mpiexec it is a single rank and starts no daemon.
class Session {
 public:
  [[nodiscard]] static Result<Session> start();
  Session(Session&& other) noexcept : owner_(other.owner_) { other.owner_ = false; }
  Session& operator=(Session&&) = delete;
  ~Session();

 private:
  Session() = default;
  bool owner_ = true;
};

/// Whether mpiexec started this process as one of several; for programs that need a session only then.
[[nodiscard]] bool started_on_ranks();

/// Without a session there is one rank.
[[nodiscard]] int rank();
[[nodiscard]] int rank_count();

/// Sum over the ranks. @note Collective
[[nodiscard]] double sum_over_ranks(double value);
/// Sums of several values, in place. @note Collective
void sum_over_ranks(double* values, int count);
/// True on every rank when it is on every rank. @note Collective
[[nodiscard]] bool on_every_rank(bool value);
/// The error of the first rank that has one, on every rank. @note Collective
[[nodiscard]] Result<void> agree(const Result<void>& own);
/// Process ids of all ranks, on every rank. @note Collective
[[nodiscard]] std::vector<std::int64_t> process_ids();

/// Rank 0's bytes on every rank. The others wait asleep, not spinning: for the long waits between steps of a
/// coupled run. @note Collective
void broadcast_passively(void* data, std::uint64_t bytes);
/// Rank 0's values on every rank, the size as well. @note Collective
void broadcast_passively(std::vector<double>& values);

/// Ends all ranks at once: for a rank that fails alone.
[[noreturn]] void abort_all(int status);

} // namespace drogue::la
