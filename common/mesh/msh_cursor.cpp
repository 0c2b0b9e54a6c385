// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/mesh/msh_cursor.hpp"

#include <algorithm>
#include <cctype>

namespace drogue::mesh {
namespace {

constexpr const char* blanks = " \t\r\n\f\v";
constexpr std::size_t most_shown = 40; ///< characters of a wrong word

} // namespace

void MshCursor::skip(const char* characters) {
  at_ = std::min(content_.find_first_not_of(characters, at_), content_.size());
}

std::string_view MshCursor::word() {
  skip(blanks);
  word_ = at_;
  at_ = std::min(content_.find_first_of(blanks, at_), content_.size());
  return std::string_view(content_).substr(word_, at_ - word_);
}

std::string MshCursor::quoted() {
  skip(blanks);
  word_ = at_;
  const std::size_t end = content_.find_first_of("\"\n", at_ + 1);
  if (at_ >= content_.size() || content_[at_] != '"' || end == std::string::npos || content_[end] != '"')
    fail("a name in quotes expected");
  if (error_) return {};
  at_ = end + 1;
  return content_.substr(word_ + 1, end - word_ - 1);
}

void MshCursor::end_line() {
  if (error_) return;
  skip(" \t\r");
  word_ = at_;
  if (at_ < content_.size() && content_[at_++] != '\n') fail("the end of the line expected");
}

std::size_t MshCursor::count(std::uint64_t things, std::uint64_t values, std::string_view name) {
  if (error_) return 0;
  const std::size_t left = content_.size() - at_;
  const std::uint64_t least = values * (binary_ ? sizeof(std::int32_t) : 2); // a digit and a blank
  if (least == 0 || things <= left / least) return static_cast<std::size_t>(things);
  fail("{} {} do not fit into the {} bytes that are left of the file", things, name, left);
  return 0;
}

std::string MshCursor::begin_section() {
  skip(blanks);
  word_ = at_;
  if (error_ || at_ == content_.size()) return {};
  if (content_[at_] != '$') fail("after $End{} another section must begin", shown(section_));
  const std::string_view w = word();
  section_ = w.empty() ? std::string() : std::string(w.substr(1));
  if (section_.empty()) fail("a section must have a name");
  end_line();
  return error_ ? std::string() : section_;
}

void MshCursor::end_section() {
  if (error_) return;
  const std::string end = "$End" + section_;
  if (word() != end) {
    if (content_.find("\n" + end, word_) == std::string::npos)
      fail("the section ${} has no {}", shown(section_), shown(end));
    else
      fail("the section ${} holds more than it announces: {} expected", shown(section_), shown(end));
  }
  end_line();
}

void MshCursor::skip_section() {
  if (error_) return;
  at_ = std::min(content_.find("\n$End" + section_, at_ - 1), content_.size());
}

std::string MshCursor::place() const {
  if (binary_) return fmt::format("{}: byte {}", file_, word_);
  const auto end = content_.begin() + static_cast<std::ptrdiff_t>(word_);
  return fmt::format("{}:{}", file_, 1 + std::count(content_.begin(), end, '\n'));
}

std::string MshCursor::shown(std::string_view word) {
  std::string text(word.substr(0, most_shown));
  for (char& c : text)
    if (std::isprint(static_cast<unsigned char>(c)) == 0) c = '?';
  return text;
}

} // namespace drogue::mesh
