// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/config/rules.hpp"

#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "common/config/expression.hpp"
#include "drogue/v1/rules.pb.h"

namespace drogue::config {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;

/// The allowed range in words, e.g. "in [0, 1)".
std::string range_text(const v1::Rule& rule) {
  const bool lower = rule.has_min() || rule.has_above(), upper = rule.has_max() || rule.has_below();
  const std::string low = rule.has_min() ? fmt::format("[{}", rule.min()) : fmt::format("({}", rule.above());
  const std::string high = rule.has_max() ? fmt::format("{}]", rule.max()) : fmt::format("{})", rule.below());
  if (lower && upper) return fmt::format("in {}, {}", low, high);
  if (rule.has_min()) return fmt::format("at least {}", rule.min());
  if (rule.has_above()) return fmt::format("above {}", rule.above());
  if (rule.has_max()) return fmt::format("at most {}", rule.max());
  return fmt::format("below {}", rule.below());
}

bool within(const v1::Rule& rule, double value) {
  if (!std::isfinite(value)) return false;
  return !(rule.has_min() && value < rule.min()) && !(rule.has_above() && value <= rule.above()) &&
         !(rule.has_max() && value > rule.max()) && !(rule.has_below() && value >= rule.below());
}

/// The number in a field (entry `index` of a repeated one), or nothing when it is not a number.
std::optional<double> number(const Message& m, const FieldDescriptor& f, int index) {
  const Reflection& r = *m.GetReflection();
  const bool repeated = f.is_repeated();
  switch (f.cpp_type()) {
  case FieldDescriptor::CPPTYPE_DOUBLE:
    return repeated ? r.GetRepeatedDouble(m, &f, index) : r.GetDouble(m, &f);
  case FieldDescriptor::CPPTYPE_INT32:
    return repeated ? r.GetRepeatedInt32(m, &f, index) : r.GetInt32(m, &f);
  default:
    return std::nullopt;
  }
}

class Checker {
 public:
  Checker(const Source& source, Report& report) : source_(source), report_(report) {}

  void check(const Message& message, const std::string& path) {
    const auto& descriptor = *message.GetDescriptor();
    for (int i = 0; i < descriptor.field_count(); ++i) check_field(message, *descriptor.field(i), path);
  }

 private:
  void check_field(const Message& m, const FieldDescriptor& f, const std::string& parent) {
    const Reflection& r = *m.GetReflection();
    const v1::Rule& rule = f.options().GetExtension(v1::rule);
    const std::string path = parent.empty() ? f.name() : parent + "." + f.name();
    const int count = f.is_repeated() ? r.FieldSize(m, &f) : (r.HasField(m, &f) ? 1 : 0);

    if (rule.required() && count == 0)
      report_.error(source_.where(parent), fmt::format("{} is missing{}", path, unit_text(rule)));
    if (rule.has_min_count() && count < rule.min_count())
      report_.error(source_.where(parent),
                    fmt::format("{} needs at least {} entries, has {}", path, rule.min_count(), count));
    for (int i = 0; i < count; ++i)
      check_entry(m, f, rule, f.is_repeated() ? fmt::format("{}[{}]", path, i) : path, i);
  }

  void check_entry(const Message& m, const FieldDescriptor& f, const v1::Rule& rule, const std::string& path,
                   int i) {
    const Reflection& r = *m.GetReflection();
    if (f.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE)
      check(f.is_repeated() ? r.GetRepeatedMessage(m, &f, i) : r.GetMessage(m, &f), path);
    if (const auto value = number(m, f, i); value && !within(rule, *value))
      report_.error(source_.where(path),
                    fmt::format("{} is {}; it must be {}{}", path, *value,
                                std::isfinite(*value) ? range_text(rule) : "finite", unit_text(rule)));
    if (f.cpp_type() != FieldDescriptor::CPPTYPE_STRING) return;
    const std::string text = f.is_repeated() ? r.GetRepeatedString(m, &f, i) : r.GetString(m, &f);
    if (rule.required() && text.empty()) report_.error(source_.where(path), path + " is empty");
    if (rule.input_file() && !text.empty() && !std::filesystem::is_regular_file(source_.resolve(text)))
      report_.error(source_.where(path), fmt::format("{} names a file that does not exist: {}", path,
                                                     source_.resolve(text).string()));
    if (rule.expression())
      if (const auto parsed = Expression::parse(text); !parsed)
        report_.error(source_.where(path), fmt::format("{}: {}", path, parsed.error().message));
  }

  static std::string unit_text(const v1::Rule& rule) {
    return rule.has_unit() ? fmt::format(" ({})", rule.unit()) : std::string();
  }

  const Source& source_;
  Report& report_;
};

} // namespace

void check_rules(const Message& message, const Source& source, Report& report) {
  Checker(source, report).check(message, "");
}

} // namespace drogue::config
