// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "coupler/acceleration/vector_ops.hpp"

namespace drogue::acceleration {

/// A vector of a secant: as it was computed, or rounded to single precision, which halves the memory that
/// has to be read. All sums are in double precision.
class SecantVector {
 public:
  SecantVector() = default;
  explicit SecantVector(std::vector<double> values) : exact_(std::move(values)) {}

  [[nodiscard]] SecantVector rounded() const {
    SecantVector result;
    result.rounded_ = is_rounded() ? rounded_ : std::vector<float>(exact_.begin(), exact_.end());
    return result;
  }
  [[nodiscard]] bool is_rounded() const noexcept { return !rounded_.empty(); }
  [[nodiscard]] std::vector<double> values() const {
    return is_rounded() ? std::vector<double>(rounded_.begin(), rounded_.end()) : exact_;
  }

  /// Product of the rows `start` to `start + with.size()` with `with`.
  [[nodiscard]] double dot(std::size_t start, std::span<const double> with) const noexcept {
    return is_rounded() ? acceleration::dot(part(rounded_, start, with.size()), with)
                        : acceleration::dot(part(exact_, start, with.size()), with);
  }
  /// y += c times the rows `start` to `start + y.size()`.
  void add_to(std::span<double> y, double c, std::size_t start) const noexcept {
    if (is_rounded()) {
      add_scaled(c, part(rounded_, start, y.size()), y);
    } else {
      add_scaled(c, part(exact_, start, y.size()), y);
    }
  }

 private:
  template <class T>
  static std::span<const T> part(const std::vector<T>& v, std::size_t start, std::size_t size) noexcept {
    return std::span(v).subspan(start, size);
  }

  std::vector<double> exact_; ///< one of the two is empty
  std::vector<float> rounded_;
};

} // namespace drogue::acceleration
