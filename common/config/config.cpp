// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/config/config.hpp"

#include <algorithm>
#include <fstream>
#include <sstream>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <google/protobuf/io/tokenizer.h>
#include <google/protobuf/io/zero_copy_stream_impl.h>
#include <google/protobuf/text_format.h>

#include "common/base/nearest.hpp"
#include "common/config/rules.hpp"

namespace drogue::config {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::TextFormat;

/// The text between the `n`-th pair of double quotes (from 0) in `text`; empty when there is none.
std::string quoted(const std::string& text, int n) {
  std::size_t begin = 0;
  for (int i = 0;; ++i) {
    const std::size_t open = text.find('"', begin);
    if (open == std::string::npos) return {};
    const std::size_t close = text.find('"', open + 1);
    if (close == std::string::npos) return {};
    if (i == n) return text.substr(open + 1, close - open - 1);
    begin = close + 1;
  }
}

std::string suggestion(const std::string& name, const std::vector<std::string>& candidates) {
  const std::string nearest = nearest_name(name, candidates);
  return nearest.empty() ? std::string() : fmt::format("; did you mean \"{}\"?", nearest);
}

std::vector<std::string> field_names(const Descriptor& type) {
  std::vector<std::string> names;
  for (int i = 0; i < type.field_count(); ++i) names.push_back(type.field(i)->name());
  return names;
}

/// Rewords what the parser says: unknown fields and enumeration values get the nearest valid name.
class Collector : public google::protobuf::io::ErrorCollector {
 public:
  Collector(const Source& source, const Descriptor& root, const std::string& text, Report& report)
      : source_(source), root_(root), report_(report) {
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);) lines_.push_back(line);
  }

  void AddError(int line, google::protobuf::io::ColumnNumber column, const std::string& message) override {
    add(line, column, message);
  }
  void AddWarning(int line, google::protobuf::io::ColumnNumber column, const std::string& message) override {
    add(line, column, message);
  }

 private:
  void add(int line, int column, const std::string& message) {
    std::string text = message;
    if (message.find("has no field named") != std::string::npos) {
      const std::string type = quoted(message, 0), field = quoted(message, 1);
      const Descriptor* descriptor = root_.file()->pool()->FindMessageTypeByName(type);
      text = fmt::format("unknown field \"{}\"", field);
      move_back_to(field, line, column);
      if (descriptor) text += suggestion(field, field_names(*descriptor));
    } else if (message.find("Unknown enumeration value") != std::string::npos) {
      const std::string value = quoted(message, 0), field = quoted(message, 1);
      move_back_to(value, line, column);
      const std::vector<std::string> valid = enumeration_of(root_, field);
      text = fmt::format("\"{}\" is not a value of {}{} (valid: {})", value, field, suggestion(value, valid),
                         fmt::join(valid, ", "));
    }
    // The parser counts from 0, and says line -1 for errors of the file as a whole.
    const std::string file = source_.file().string();
    report_.error(line < 0 ? file : fmt::format("{}:{}:{}", file, line + 1, column + 1), text);
  }

  /// The parser points behind an unknown name; moves (line, column) back to the name itself.
  void move_back_to(const std::string& name, int& line, int& column) const {
    for (int l = std::min(line, static_cast<int>(lines_.size()) - 1); l >= 0; --l) {
      const std::string& text = lines_[static_cast<std::size_t>(l)];
      const std::size_t end = l == line ? static_cast<std::size_t>(column) : text.size();
      const std::size_t at = end < name.size() ? std::string::npos : text.rfind(name, end - name.size());
      if (at == std::string::npos) continue;
      line = l;
      column = static_cast<int>(at);
      return;
    }
  }

  /// The values of the first enumeration field called `name` at or below `type`.
  static std::vector<std::string> enumeration_of(const Descriptor& type, const std::string& name,
                                                 int depth = 0) {
    std::vector<std::string> values;
    for (int i = 0; i < type.field_count() && values.empty() && depth < 8; ++i) {
      const FieldDescriptor& f = *type.field(i);
      if (f.name() == name && f.enum_type())
        for (int k = 0; k < f.enum_type()->value_count(); ++k)
          values.push_back(f.enum_type()->value(k)->name());
      else if (f.message_type())
        values = enumeration_of(*f.message_type(), name, depth + 1);
    }
    return values;
  }

  const Source& source_;
  const Descriptor& root_;
  Report& report_;
  std::vector<std::string> lines_;
};

void record_positions(const Message& message, const TextFormat::ParseInfoTree& tree,
                      const std::string& parent, Source& source) {
  std::vector<const FieldDescriptor*> fields;
  message.GetReflection()->ListFields(message, &fields);
  for (const FieldDescriptor* f : fields) {
    const int count = f->is_repeated() ? message.GetReflection()->FieldSize(message, f) : 1;
    for (int i = 0; i < count; ++i) {
      const std::string name = f->is_repeated() ? fmt::format("{}[{}]", f->name(), i) : f->name();
      const std::string path = parent.empty() ? name : parent + "." + name;
      const int index = f->is_repeated() ? i : -1;
      const TextFormat::ParseLocation location = tree.GetLocation(f, index);
      if (location.line >= 0) source.set(path, location.line + 1, location.column + 1);
      if (!f->message_type()) continue;
      const Message& child = f->is_repeated() ? message.GetReflection()->GetRepeatedMessage(message, f, i)
                                              : message.GetReflection()->GetMessage(message, f);
      if (const auto* nested = tree.GetTreeForNested(f, index))
        record_positions(child, *nested, path, source);
    }
  }
}

} // namespace

void Report::error(const std::string& where, const std::string& text) {
  lines_.push_back(fmt::format("{}: error: {}", where, text));
}

Error Report::as_error() const {
  return {ErrorKind::config, fmt::format("{}", fmt::join(lines_, "\n"))};
}

std::string Source::where(std::string_view path) const {
  while (true) {
    if (const auto it = positions_.find(path); it != positions_.end())
      return fmt::format("{}:{}:{}", file_.string(), it->second.line, it->second.column);
    const std::size_t dot = path.rfind('.');
    if (dot == std::string_view::npos) return file_.string();
    path = path.substr(0, dot);
  }
}

std::filesystem::path Source::resolve(const std::string& name) const {
  const std::filesystem::path path(name);
  return path.is_absolute() ? path : file_.parent_path() / path;
}

Source load(const std::filesystem::path& file, Message& message, Report& report) {
  Source source(file);
  std::ifstream stream(file, std::ios::binary);
  if (!stream || std::filesystem::is_directory(file)) {
    report.error(file.string(), "cannot be opened: no such file, or it is not readable");
    return source;
  }
  std::stringstream text;
  text << stream.rdbuf();

  const std::size_t errors_before = report.lines().size();
  Collector collector(source, *message.GetDescriptor(), text.str(), report);
  TextFormat::ParseInfoTree tree;
  TextFormat::Parser parser;
  parser.AllowUnknownField(true); // so that all of them are reported, not only the first
  parser.AllowPartialMessage(true);
  parser.RecordErrorsTo(&collector);
  parser.WriteLocationsTo(&tree);
  const bool parsed = parser.ParseFromString(text.str(), &message);
  record_positions(message, tree, "", source);
  if (!parsed && report.lines().size() == errors_before) report.error(file.string(), "cannot be parsed");
  if (parsed) {
    source.set_parsed();
    check_rules(message, source, report);
  }
  return source;
}

void report_unknown_name(Report& report, const std::string& where, std::string_view what,
                         std::string_view name, std::string_view in, std::span<const std::string> valid) {
  const std::vector<std::string> names(valid.begin(), valid.end());
  report.error(where, fmt::format("there is no {} named \"{}\" in {}{} (there are: {})", what, name, in,
                                  suggestion(std::string(name), names), fmt::join(names, ", ")));
}

} // namespace drogue::config
