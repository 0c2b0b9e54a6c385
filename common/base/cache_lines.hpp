// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <new>
#include <vector>

#include <sys/mman.h>

namespace drogue {

/// Gives memory that starts at a cache line, so that rows of eight doubles lie in one line each; much of it
/// stands in large pages where the system has them.
template <class T>
struct CacheLineAllocator {
  using value_type = T;
  CacheLineAllocator() = default;
  template <class U>
  CacheLineAllocator(const CacheLineAllocator<U>&) noexcept {}
  [[nodiscard]] T* allocate(std::size_t n) {
    const std::size_t bytes = n * sizeof(T);
    void* const p = ::operator new(bytes, alignment(bytes));
    if (is_large(bytes)) madvise(p, bytes, MADV_HUGEPAGE); // a wish: without effect where there are none
    return static_cast<T*>(p);
  }
  void deallocate(T* p, std::size_t n) noexcept { ::operator delete(p, alignment(n * sizeof(T))); }
  friend bool operator==(const CacheLineAllocator&, const CacheLineAllocator&) { return true; }

 private:
  static constexpr std::size_t large_page = std::size_t{2} << 20;
  static bool is_large(std::size_t bytes) { return bytes >= large_page; }
  static std::align_val_t alignment(std::size_t bytes) {
    return std::align_val_t{is_large(bytes) ? large_page : 64};
  }
};

/// A vector whose first value lies at the start of a cache line.
template <class T>
using CacheLines = std::vector<T, CacheLineAllocator<T>>;

} // namespace drogue
