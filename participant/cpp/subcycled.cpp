// SPDX-License-Identifier: GPL-3.0-or-later
#include "participant/cpp/subcycled.hpp"

#include <algorithm>
#include <cstdlib>
#include <fstream>

namespace drogue::participant {
namespace {

constexpr const char* inputs_file = "subcycled.inputs";

/// to += factor * values
void add(double factor, const FloatArray& values, FloatArray& to) {
  for (std::size_t i = 0; i < to.values.size(); ++i) to.values[i] += factor * values.values[i];
}

/// The field of that name and of that size; nullptr: none.
const FloatArray* find(const Fields& fields, const std::string& name, std::size_t size) {
  const auto it = fields.find(name);
  return it != fields.end() && it->second.values.size() == size ? &it->second : nullptr;
}

/// A line "SIZE NAME ROWS COLUMNS ..." and the values for each field, after their number.
void put(std::ostream& to, const Fields& fields) {
  to << fields.size() << '\n';
  for (const auto& [name, field] : fields) {
    to << field.values.size() << ' ' << name << ' ' << field.shape.size();
    for (const std::uint64_t extent : field.shape) to << ' ' << extent;
    to << '\n';
    to.write(reinterpret_cast<const char*>(field.values.data()),
             static_cast<std::streamsize>(field.values.size() * sizeof(double)));
  }
}

Fields take(std::istream& from) {
  Fields fields;
  std::size_t count = 0, size = 0, dimensions = 0;
  from >> count;
  for (std::size_t i = 0; i < count && from; ++i) {
    std::string name;
    from >> size >> name >> dimensions;
    FloatArray& field = fields[name];
    for (std::uint64_t extent = 0; field.shape.size() < dimensions && from >> extent;)
      field.shape.push_back(extent);
    from.ignore(1);
    if (!from) break;
    field.values.resize(size);
    from.read(reinterpret_cast<char*>(field.values.data()),
              static_cast<std::streamsize>(size * sizeof(double)));
  }
  return fields;
}

} // namespace

Description Subcycled::describe() {
  Description d = inner_.describe();
  means_.clear();
  for (const v1::FieldContract& output : d.outputs)
    if (output.time_level() == v1::FieldContract::MEAN_OF_STEP) means_.push_back(output.name());
  return d;
}

Result<void> Subcycled::begin_step(const StepInfo& step) {
  step_ = step;
  return {};
}

FloatArray Subcycled::at(const Fields& inputs, const std::string& name, double share) const {
  FloatArray value = inputs.at(name);
  const std::size_t size = value.values.size();
  const FloatArray* start = find(inputs, name + "_start", size);
  const FloatArray* last = start ? start : find(last_, name, size);
  if (!last) return value;
  const FloatArray* before = start ? nullptr : find(before_, name, size);
  double w_now = share, w_last = 1 - share, w_before = 0;
  if (interpolation_ == Interpolation::quadratic && before) {
    const double b = last_time_step_ / step_.time_step;
    w_now = share * (share + b) / (1 + b);
    w_last = (1 - share) * (share + b) / b;
    w_before = share * (share - 1) / (b * (1 + b));
  }
  for (double& v : value.values) v *= w_now;
  add(w_last, *last, value);
  if (w_before != 0) add(w_before, *before, value);
  return value;
}

Fields Subcycled::inputs_of_part(const Fields& inputs, double begin, double end) const {
  const std::string mark = "_start";
  Fields part;
  for (const auto& [name, value] : inputs) {
    const bool marked = name.size() > mark.size() && name.substr(name.size() - mark.size()) == mark;
    const std::string of = marked ? name.substr(0, name.size() - mark.size()) : name;
    part[name] = marked && inputs.count(of) > 0 ? at(inputs, of, begin) : at(inputs, name, end);
  }
  return part;
}

Result<IterationReport> Subcycled::iterate(const Fields& inputs, Fields& outputs) {
  DROGUE_TRY(rollback());
  IterationReport all;
  Fields means;
  const double dt = step_.time_step / parts_;
  for (int k = 0; k < parts_; ++k) {
    if (k > 0) DROGUE_TRY(inner_.end_part());
    in_part_ = false;
    DROGUE_TRY(inner_.begin_step({step_.step, step_.attempt, step_.time + k * dt, dt}));
    in_part_ = true;
    const double begin = static_cast<double>(k) / parts_, end = static_cast<double>(k + 1) / parts_;
    const auto report = inner_.iterate(inputs_of_part(inputs, begin, end), outputs);
    if (!report) return report.error();
    all.inner_iterations += report->inner_iterations;
    all.inner_residual = std::max(all.inner_residual, report->inner_residual);
    all.converged = all.converged && report->converged;
    for (const std::string& name : means_) {
      const auto output = outputs.find(name);
      if (output == outputs.end()) continue;
      FloatArray& mean = means[name];
      mean.shape = output->second.shape;
      mean.values.resize(output->second.values.size(), 0.0);
      add(1.0 / parts_, output->second, mean);
    }
  }
  for (auto& [name, mean] : means) outputs[name] = std::move(mean);
  given_ = inputs;
  return all;
}

Result<void> Subcycled::commit(bool write_output) {
  DROGUE_TRY(inner_.commit(write_output));
  in_part_ = false;
  before_ = std::move(last_);
  last_ = std::move(given_);
  last_time_step_ = step_.time_step;
  return {};
}

Result<void> Subcycled::rollback() {
  if (in_part_) DROGUE_TRY(inner_.rollback());
  in_part_ = false;
  return inner_.undo_parts();
}

Result<ReplacedMesh> Subcycled::replace_mesh(const NewMesh& mesh, bool restoring) {
  last_.clear(); // numbered as the old mesh
  before_.clear();
  return inner_.replace_mesh(mesh, restoring);
}

Result<void> Subcycled::checkpoint(const std::filesystem::path& directory) {
  DROGUE_TRY(inner_.checkpoint(directory));
  std::ofstream file(directory / inputs_file, std::ios::binary);
  file << fmt::format("{:a}\n", last_time_step_);
  put(file, last_);
  put(file, before_);
  file.close();
  return file ? Result<void>() : internal_error("cannot write {}", (directory / inputs_file).string());
}

Result<void> Subcycled::restore(const std::filesystem::path& directory) {
  DROGUE_TRY(inner_.restore(directory));
  std::ifstream file(directory / inputs_file, std::ios::binary);
  std::string time_step;
  file >> time_step;
  last_time_step_ = std::strtod(time_step.c_str(), nullptr);
  last_ = take(file);
  before_ = take(file);
  return file ? Result<void>() : config_error("cannot read {}", (directory / inputs_file).string());
}

} // namespace drogue::participant
