// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace drogue {

/// Processors that this process may run on.
[[nodiscard]] int usable_processors();

/// Threads to use when the config leaves it open: what OMP_NUM_THREADS says (the coupler sets it to 1 for its
/// solvers), else one for each processor that this process may use.
[[nodiscard]] int default_threads();

/// Threads that do the same work on their own share of the data. Between jobs they sleep: a waiting solver
/// leaves the processors to the others.
class WorkerPool {
 public:
  /// The calling thread is worker 0; `workers` - 1 threads are started. @pre workers >= 1
  explicit WorkerPool(int workers);
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  [[nodiscard]] int size() const noexcept { return static_cast<int>(threads_.size()) + 1; }
  /// Calls job(worker) once for each worker; returns when all have returned. `job` must not throw.
  void run(const std::function<void(int)>& job);

 private:
  void work(int worker);

  std::mutex mutex_;
  std::condition_variable begun_, done_;
  const std::function<void(int)>* job_ = nullptr;
  std::uint64_t jobs_begun_ = 0;
  int working_ = 0;
  bool stop_ = false;
  std::vector<std::jthread> threads_; // last: joined before the rest goes
};

} // namespace drogue
