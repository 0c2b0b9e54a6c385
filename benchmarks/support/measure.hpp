// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <string>

#include <malloc.h>
#include <sys/resource.h>
#include <unistd.h>

#include <fmt/format.h>

/// Rows as Google Benchmark's csv has them (name,iterations,value,value,unit), a clock, and memory: for
/// benchmarks whose figures are not times alone.
namespace drogue::bench {

inline void row(const std::string& name, int runs, double value, const char* unit) {
  fmt::print("\"{}\",{},{:.6g},{:.6g},{}\n", name, runs, value, value, unit);
  std::fflush(stdout);
}
inline void row(const std::string& name, double value, const char* unit) {
  row(name, 1, value, unit);
}

template <class Function>
[[nodiscard]] double seconds(Function&& f) {
  const auto start = std::chrono::steady_clock::now();
  f();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Processor time of this process's threads: what it takes is nearly the same whether others work or not.
[[nodiscard]] inline double processor_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto in_seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return in_seconds(usage.ru_utime) + in_seconds(usage.ru_stime);
}

template <class Function>
[[nodiscard]] double least(int runs, Function&& f) {
  double best = INFINITY;
  for (int k = 0; k < runs; ++k) best = std::min(best, seconds(f));
  return best;
}

template <class Function>
[[nodiscard]] double least_processor_time(int runs, Function&& f) {
  double best = INFINITY;
  for (int k = 0; k < runs; ++k) {
    const double start = processor_seconds();
    f();
    best = std::min(best, processor_seconds() - start);
  }
  return best;
}

/// Memory of the process now.
[[nodiscard]] inline double resident_megabytes() {
  malloc_trim(0);
  std::ifstream statm("/proc/self/statm");
  double size = 0;
  double resident = 0;
  statm >> size >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

/// The most that it ever had.
[[nodiscard]] inline double peak_megabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) * 1024 / 1e6;
}

/// Memory of the process now, a page that several processes have (a library's) shared out among them.
[[nodiscard]] inline double proportional_megabytes() {
  std::ifstream rollup("/proc/self/smaps_rollup");
  std::string word;
  double kilobytes = 0;
  while (rollup >> word)
    if (word == "Pss:" && rollup >> kilobytes) break;
  return kilobytes * 1024 / 1e6;
}

/// Says on standard error what failed, when something did.
inline bool require(bool ok, const std::string& what) {
  if (!ok) fmt::print(stderr, "benchmark: {}\n", what);
  return ok;
}

} // namespace drogue::bench
