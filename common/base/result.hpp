// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cassert>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include <fmt/format.h>

namespace drogue {

/// What went wrong, and with it the exit status of an executable (docs/protocol.md lists them).
enum class ErrorKind {
  internal = 1,    ///< a bug or a third-party failure
  config = 2,      ///< bad config, command line or input file
  numerical = 3,   ///< not converged, inverted element
  peer = 4,        ///< a participant died or did not answer
  interrupted = 5, ///< stopped by a signal
};

/// An error that a user, a file or a peer can cause. Bugs are assertions.
struct Error {
  ErrorKind kind = ErrorKind::internal;
  std::string message;
  /// A smaller step may help (ErrorKind::numerical), or a new start of the participant (peer).
  bool retryable = false;
};

[[nodiscard]] inline int exit_status(const Error& error) {
  return static_cast<int>(error.kind);
}

template <class... Args>
[[nodiscard]] Error config_error(fmt::format_string<Args...> text, Args&&... args) {
  return {ErrorKind::config, fmt::format(text, std::forward<Args>(args)...)};
}
template <class... Args>
[[nodiscard]] Error numerical_error(fmt::format_string<Args...> text, Args&&... args) {
  return {ErrorKind::numerical, fmt::format(text, std::forward<Args>(args)...)};
}
template <class... Args>
[[nodiscard]] Error retryable_error(fmt::format_string<Args...> text, Args&&... args) {
  return {ErrorKind::numerical, fmt::format(text, std::forward<Args>(args)...), true};
}
template <class... Args>
[[nodiscard]] Error peer_error(fmt::format_string<Args...> text, Args&&... args) {
  return {ErrorKind::peer, fmt::format(text, std::forward<Args>(args)...)};
}
template <class... Args>
[[nodiscard]] Error internal_error(fmt::format_string<Args...> text, Args&&... args) {
  return {ErrorKind::internal, fmt::format(text, std::forward<Args>(args)...)};
}

/// A value or an Error. Test it before taking the value.
template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : content_(std::move(value)) {}
  Result(Error error) : content_(std::move(error)) {}

  [[nodiscard]] bool ok() const { return std::holds_alternative<T>(content_); }
  explicit operator bool() const { return ok(); }

  [[nodiscard]] T& value() & { return assert(ok()), std::get<T>(content_); }
  [[nodiscard]] const T& value() const& { return assert(ok()), std::get<T>(content_); }
  [[nodiscard]] T&& value() && { return assert(ok()), std::get<T>(std::move(content_)); }
  T& operator*() & { return value(); }
  const T& operator*() const& { return value(); }
  T&& operator*() && { return std::move(*this).value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }

  [[nodiscard]] const Error& error() const { return assert(!ok()), std::get<Error>(content_); }

 private:
  std::variant<T, Error> content_;
};

template <>
class [[nodiscard]] Result<void> {
 public:
  Result() = default;
  Result(Error error) : error_(std::move(error)) {}
  [[nodiscard]] bool ok() const { return !error_.has_value(); }
  explicit operator bool() const { return ok(); }
  [[nodiscard]] const Error& error() const { return assert(!ok()), *error_; }

 private:
  std::optional<Error> error_;
};

/// Passes an error of `expression` (a Result) on to the caller.
#define DROGUE_TRY(expression)                                                                               \
  do {                                                                                                       \
    if (auto drogue_try_result = (expression); !drogue_try_result) return drogue_try_result.error();         \
  } while (false)

} // namespace drogue
