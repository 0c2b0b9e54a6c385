// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <charconv>
#include <concepts>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>

#include "common/base/result.hpp"

namespace drogue::mesh {

/// Walks over the content of a .msh file and never beyond its end. The first thing that is wrong stays as
/// error(); from then on all numbers are zero and all names empty, so that it is enough to look once a
/// section.
class MshCursor {
 public:
  MshCursor(std::string file, std::string content) : file_(std::move(file)), content_(std::move(content)) {}

  void set_binary(bool binary) { binary_ = binary; }
  [[nodiscard]] bool binary() const { return binary_; }
  [[nodiscard]] const std::optional<Error>& error() const { return error_; }

  /// Stops at the word read last: "FILE:LINE: ..." or, in a binary file, "FILE: byte N: ...".
  template <class... Args>
  void fail(fmt::format_string<Args...> text, Args&&... args) {
    if (!error_) error_ = config_error("{}: {}", place(), fmt::format(text, std::forward<Args>(args)...));
  }

  /// A number, in text or in binary form as the file is.
  template <class T>
  T number() {
    return binary_ ? binary_number<T>() : text_number<T>();
  }
  /// A number in text form.
  template <class T>
  T text_number() {
    const std::string_view w = word();
    const bool plus = !w.empty() && w.front() == '+';
    T value{};
    const auto [end, problem] = std::from_chars(w.data() + (plus ? 1 : 0), w.data() + w.size(), value);
    if (error_ || (problem == std::errc() && end == w.data() + w.size())) return error_ ? T{} : value;
    fail("{} expected, not \"{}\"", std::integral<T> ? "a whole number" : "a number", shown(w));
    return T{};
  }
  /// A name in quotes.
  std::string quoted();
  /// What is left of a line: nothing but blanks.
  void end_line();

  /// The number of things to come, each of `values` numbers. Fails, and gives 0, when they cannot be in what
  /// is left of the file: nothing is allocated for them.
  std::size_t count(std::uint64_t things, std::uint64_t values, std::string_view name);

  /// Name of the section that begins here; empty at the end of the file.
  std::string begin_section();
  /// $End of the section begun last.
  void end_section();
  /// Goes to the end of a section that is not read.
  void skip_section();

 private:
  template <class T>
  T binary_number() {
    T value{};
    word_ = at_;
    if (content_.size() - at_ < sizeof value) fail("the file ends within a number");
    if (error_) return T{};
    std::memcpy(&value, content_.data() + at_, sizeof value);
    at_ += sizeof value;
    return value;
  }
  /// The next word; empty at the end of the file.
  std::string_view word();
  void skip(const char* characters);
  [[nodiscard]] std::string place() const;
  [[nodiscard]] static std::string shown(std::string_view word);

  std::string file_, content_, section_;
  bool binary_ = false;
  std::size_t at_ = 0, word_ = 0; ///< next byte; first one of the word or number read last
  std::optional<Error> error_;
};

} // namespace drogue::mesh
