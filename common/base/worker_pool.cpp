// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/base/worker_pool.hpp"

#include <algorithm>
#include <cstdlib>

#include <sched.h>

namespace drogue {

int usable_processors() {
  cpu_set_t usable;
  return sched_getaffinity(0, sizeof usable, &usable) == 0 ? CPU_COUNT(&usable) : 1;
}

int default_threads() {
  if (const char* wanted = std::getenv("OMP_NUM_THREADS")) return std::clamp(std::atoi(wanted), 1, 256);
  return usable_processors();
}

WorkerPool::WorkerPool(int workers) {
  for (int worker = 1; worker < workers; ++worker) threads_.emplace_back([this, worker] { work(worker); });
}

WorkerPool::~WorkerPool() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  begun_.notify_all();
}

void WorkerPool::run(const std::function<void(int)>& job) {
  {
    const std::lock_guard lock(mutex_);
    job_ = &job;
    working_ = size() - 1;
    ++jobs_begun_;
  }
  begun_.notify_all();
  job(0);
  std::unique_lock lock(mutex_);
  done_.wait(lock, [this] { return working_ == 0; });
}

void WorkerPool::work(int worker) {
  std::uint64_t jobs_done = 0;
  while (true) {
    const std::function<void(int)>* job = nullptr;
    {
      std::unique_lock lock(mutex_);
      begun_.wait(lock, [&] { return stop_ || jobs_begun_ > jobs_done; });
      if (stop_) return;
      ++jobs_done;
      job = job_;
    }
    (*job)(worker);
    const std::lock_guard lock(mutex_);
    if (--working_ == 0) done_.notify_one();
  }
}

} // namespace drogue
