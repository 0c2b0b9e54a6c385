// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/io/vtu.hpp"

#include <zlib.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <fstream>

#include "common/io/atomic_file.hpp"

namespace drogue::io {
namespace {

using mesh::ElementBlock;
using mesh::ElementKind;

std::uint8_t vtk_type(ElementKind kind) {
  switch (kind) {
  case ElementKind::point1:
    return 1;
  case ElementKind::line2:
    return 3;
  case ElementKind::line3:
    return 21;
  case ElementKind::tri3:
    return 5;
  case ElementKind::tri6:
    return 22;
  case ElementKind::quad4:
    return 9;
  case ElementKind::quad9:
    return 28;
  case ElementKind::tet4:
    return 10;
  case ElementKind::tet10:
    return 24;
  case ElementKind::hex27:
    return 29;
  }
  return 0;
}

std::string escape(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '"')
      out += "&quot;";
    else
      out += c;
  }
  return out;
}

/// The appended section: arrays one after the other, each cut in blocks that are compressed alone and
/// preceded by {number of blocks, block length, length of the last block if shorter, compressed lengths}, all
/// UInt64.
class AppendedData {
 public:
  /// Returns the array's offset in the section.
  template <class T>
  Result<std::uint64_t> add(std::span<const T> values) {
    return add_bytes(std::as_bytes(values));
  }
  [[nodiscard]] const std::string& bytes() const { return bytes_; }

 private:
  static constexpr std::uint64_t block_length = 1U << 18U;

  Result<std::uint64_t> add_bytes(std::span<const std::byte> values) {
    const std::uint64_t offset = bytes_.size();
    const std::uint64_t blocks = (values.size() + block_length - 1) / block_length;
    std::vector<std::uint64_t> head = {blocks, block_length, values.size() % block_length};
    head.resize(3 + blocks);
    bytes_.append(head.size() * sizeof(std::uint64_t), '\0');
    for (std::uint64_t b = 0; b < blocks; ++b) {
      const auto block =
          values.subspan(b * block_length, std::min(block_length, values.size() - b * block_length));
      uLongf length = compressBound(block.size());
      buffer_.resize(length);
      if (compress2(buffer_.data(), &length, reinterpret_cast<const Bytef*>(block.data()), block.size(), 1) !=
          Z_OK)
        return internal_error("zlib cannot compress {} bytes", block.size());
      bytes_.append(reinterpret_cast<const char*>(buffer_.data()), length);
      head[3 + b] = length;
    }
    std::memcpy(bytes_.data() + offset, head.data(), head.size() * sizeof(std::uint64_t));
    return offset;
  }

  std::string bytes_;
  std::vector<Bytef> buffer_;
};

/// The XML part and the appended section, written side by side.
class VtuText {
 public:
  template <class T>
  Result<void> array(const std::string& type, const std::string& name, int components,
                     std::span<const T> values) {
    const auto offset = appended_.add(values);
    if (!offset) return offset.error();
    xml_ += fmt::format(
        "        <DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" "
        "offset=\"{}\"/>\n",
        type, escape(name), components, *offset);
    return {};
  }
  void line(const std::string& text) { xml_ += text + '\n'; }
  [[nodiscard]] const std::string& xml() const { return xml_; }
  [[nodiscard]] const std::string& appended() const { return appended_.bytes(); }

 private:
  std::string xml_;
  AppendedData appended_;
};

/// For each node of a VTK cell its place in our (Gmsh's) node order; empty where the two agree.
std::span<const int> vtk_order(ElementKind kind) {
  static constexpr int tet10[] = {0, 1, 2, 3, 4, 5, 6, 7, 9, 8};
  static constexpr int hex27[] = {0,  1,  2,  3,  4,  5,  6,  7,  8,  11, 13, 9,  16, 18,
                                  19, 17, 10, 12, 14, 15, 22, 23, 21, 24, 20, 25, 26};
  if (kind == ElementKind::tet10) return tet10;
  if (kind == ElementKind::hex27) return hex27;
  return {};
}

struct Cells {
  std::vector<std::int32_t> connectivity;
  std::vector<std::int64_t> offsets;
  std::vector<std::uint8_t> types;
};

Cells cells_of(std::span<const ElementBlock* const> blocks) {
  Cells cells;
  for (const ElementBlock* block : blocks) {
    const int nodes = mesh::nodes_per_element(block->kind);
    const auto order = vtk_order(block->kind);
    if (order.empty())
      cells.connectivity.insert(cells.connectivity.end(), block->nodes.begin(), block->nodes.end());
    else
      for (std::int32_t e = 0; e < block->count(); ++e)
        for (const int a : order)
          cells.connectivity.push_back(block->element(e)[static_cast<std::size_t>(a)]);
    for (std::int32_t e = 0; e < block->count(); ++e)
      cells.offsets.push_back((cells.offsets.empty() ? 0 : cells.offsets.back()) + nodes);
    cells.types.resize(cells.offsets.size(), vtk_type(block->kind));
  }
  return cells;
}

Result<void> check_array(const Array& array, std::size_t count, const char* where) {
  if (array.components > 0 && array.values.size() == count * static_cast<std::size_t>(array.components))
    return {};
  return internal_error("array \"{}\": {} values for {} {} of {} components", array.name, array.values.size(),
                        count, where, array.components);
}

Result<void> add_arrays(VtuText& text, const char* section, std::span<const Array> arrays,
                        std::size_t count) {
  text.line(fmt::format("      <{}>", section));
  for (const Array& array : arrays) {
    DROGUE_TRY(check_array(array, count, section));
    DROGUE_TRY(text.array("Float64", array.name, array.components, array.values));
  }
  text.line(fmt::format("      </{}>", section));
  return {};
}

Result<void> add_piece(VtuText& text, const VtuData& data) {
  const Cells cells = cells_of(data.blocks);
  const std::size_t point_count = data.points.size() / 3;
  text.line(
      fmt::format("    <Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">", point_count, cells.types.size()));
  DROGUE_TRY(add_arrays(text, "PointData", data.point_data, point_count));
  DROGUE_TRY(add_arrays(text, "CellData", data.cell_data, cells.types.size()));
  text.line("      <Points>");
  DROGUE_TRY(text.array("Float64", "Points", 3, data.points));
  text.line("      </Points>\n      <Cells>");
  DROGUE_TRY(text.array("Int32", "connectivity", 1, std::span<const std::int32_t>(cells.connectivity)));
  DROGUE_TRY(text.array("Int64", "offsets", 1, std::span<const std::int64_t>(cells.offsets)));
  DROGUE_TRY(text.array("UInt8", "types", 1, std::span<const std::uint8_t>(cells.types)));
  text.line("      </Cells>\n    </Piece>");
  return {};
}

/// Path of `file` from the folder of `from`.
std::string relative_to(const std::filesystem::path& from, const std::filesystem::path& file) {
  const auto folder = from.has_parent_path() ? from.parent_path() : std::filesystem::path(".");
  const auto relative = file.lexically_normal().lexically_relative(folder.lexically_normal());
  return escape((relative.empty() ? file : relative).generic_string());
}

std::string array_names(const char* section, std::span<const Array> arrays) {
  std::string text = fmt::format("    <{}>\n", section);
  for (const Array& array : arrays)
    text += fmt::format("      <PDataArray type=\"Float64\" Name=\"{}\" NumberOfComponents=\"{}\"/>\n",
                        escape(array.name), array.components);
  return text + fmt::format("    </{}>\n", section);
}

} // namespace

Result<void> write_pvtu(const std::filesystem::path& file, const VtuData& data,
                        std::span<const std::filesystem::path> pieces) {
  std::string text = "<?xml version=\"1.0\"?>\n<VTKFile type=\"PUnstructuredGrid\" version=\"1.0\" "
                     "byte_order=\"LittleEndian\" "
                     "header_type=\"UInt64\">\n  <PUnstructuredGrid GhostLevel=\"0\">\n";
  text += array_names("PPointData", data.point_data) + array_names("PCellData", data.cell_data);
  text += "    <PPoints>\n      <PDataArray type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\"/>\n"
          "    </PPoints>\n";
  for (const std::filesystem::path& piece : pieces)
    text += fmt::format("    <Piece Source=\"{}\"/>\n", relative_to(file, piece));
  return write_file(file, text + "  </PUnstructuredGrid>\n</VTKFile>\n");
}

Result<void> write_vtu(const std::filesystem::path& file, const VtuData& data) {
  VtuText text;
  text.line(
      "<?xml version=\"1.0\"?>\n"
      "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\" "
      "compressor=\"vtkZLibDataCompressor\">\n  <UnstructuredGrid>");
  DROGUE_TRY(add_piece(text, data));
  text.line("  </UnstructuredGrid>\n  <AppendedData encoding=\"raw\">");
  auto out = AtomicFile::create(file);
  if (!out) return out.error();
  DROGUE_TRY(out->write(text.xml()));
  DROGUE_TRY(out->write("_"));
  DROGUE_TRY(out->write(text.appended()));
  DROGUE_TRY(out->write("\n  </AppendedData>\n</VTKFile>\n"));
  return out->commit();
}

Result<void> PvdCollection::add(double time, const std::filesystem::path& vtu) {
  std::string entry =
      fmt::format("    <DataSet timestep=\"{}\" part=\"0\" file=\"{}\"/>", time, relative_to(file_, vtu));
  if (!entries_.empty() && entries_.back() == entry) return {};
  entries_.push_back(std::move(entry));
  return write();
}

Result<void> PvdCollection::continue_from(std::size_t count) {
  entries_.clear();
  std::ifstream stream(file_);
  for (std::string line; entries_.size() < count && std::getline(stream, line);)
    if (line.find("<DataSet ") != std::string::npos) entries_.push_back(line);
  if (entries_.size() < count)
    return config_error("{} names {} files, fewer than the {} it named at the checkpoint: it was altered",
                        file_.string(), entries_.size(), count);
  return std::filesystem::exists(file_) ? write() : Result<void>();
}

Result<void> PvdCollection::write() const {
  std::string text = "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" "
                     "byte_order=\"LittleEndian\">\n  <Collection>\n";
  for (const std::string& entry : entries_) text += entry + '\n';
  return write_file(file_, text + "  </Collection>\n</VTKFile>\n");
}

} // namespace drogue::io
