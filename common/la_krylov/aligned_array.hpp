// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <new>

#include <sys/mman.h>

namespace drogue::la {

/// An array on a cache-line boundary, zero at first. A large one stands in large pages where the system has
/// them: loops that jump about in it then seldom miss the table of addresses.
template <class T>
class AlignedArray {
 public:
  AlignedArray() = default;
  explicit AlignedArray(std::size_t size) : data_(allocate(size)), size_(size) {
    std::fill_n(data_.get(), size, T{});
  }
  [[nodiscard]] T* data() { return data_.get(); }
  [[nodiscard]] const T* data() const { return data_.get(); }
  [[nodiscard]] std::size_t size() const { return size_; }

 private:
  static constexpr std::size_t line = 64;
  static constexpr std::size_t large_page = std::size_t{2} << 20;

  struct Free {
    std::align_val_t alignment{line};
    void operator()(T* p) const { ::operator delete(p, alignment); }
  };
  using Memory = std::unique_ptr<T[], Free>;

  static Memory allocate(std::size_t size) {
    const std::size_t bytes = std::max<std::size_t>(size, 1) * sizeof(T);
    const bool large = bytes >= 2 * large_page;
    const std::align_val_t alignment{large ? large_page : line};
    void* const p = ::operator new(bytes, alignment);
    if (large) madvise(p, bytes, MADV_HUGEPAGE); // a wish: without effect where there are none
    return Memory(static_cast<T*>(p), Free{alignment});
  }

  Memory data_;
  std::size_t size_ = 0;
};

} // namespace drogue::la
