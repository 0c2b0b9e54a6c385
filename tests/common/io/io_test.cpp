// SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <csignal>
#include <cstring>
#include <fstream>
#include <limits>

#include <sys/resource.h>

#include "common/io/atomic_file.hpp"
#include "common/io/csv.hpp"
#include "common/io/positions.hpp"
#include "common/io/state_file.hpp"
#include "common/io/vtu.hpp"

namespace drogue::io {
namespace {

using testing::HasSubstr;

class Io : public testing::Test {
 protected:
  void SetUp() override { std::filesystem::create_directories(folder_); }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  static std::string content(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  [[nodiscard]] std::size_t files_in_folder() const {
    return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder_), {}));
  }

  std::filesystem::path folder_ =
      std::filesystem::path(testing::TempDir()) /
      (std::string("drogue_io_") + testing::UnitTest::GetInstance()->current_test_info()->name());
};

TEST_F(Io, AtomicFileReplacesOnlyOnCommit) {
  const auto file = folder_ / "a.txt";
  ASSERT_TRUE(write_file(file, "old").ok());
  {
    auto out = AtomicFile::create(file);
    ASSERT_TRUE(out.ok());
    ASSERT_TRUE(out->write("new").ok());
    EXPECT_EQ(content(file), "old");
  }
  EXPECT_EQ(content(file), "old");
  EXPECT_EQ(files_in_folder(), 1U) << "the temporary file is left";
  ASSERT_TRUE(write_file(file, "new").ok());
  EXPECT_EQ(content(file), "new");
  EXPECT_EQ(files_in_folder(), 1U);
}

TEST_F(Io, AtomicFileNamesWhatCannotBeWritten) {
  ASSERT_TRUE(write_file(folder_ / "plain", "x").ok());
  const auto result = write_file(folder_ / "plain" / "below.txt", "x");
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error().kind, ErrorKind::internal);
  EXPECT_THAT(result.error().message, HasSubstr("plain/below.txt: Not a directory"));
}

TEST_F(Io, CsvRowsReadBackExactly) {
  const double third = 1.0 / 3, tiny = 5e-324;
  const auto file = folder_ / "new_folder" / "series.csv";
  auto csv = CsvWriter::create(file, {"time", "value"});
  ASSERT_TRUE(csv.ok());
  EXPECT_TRUE(csv->row({0, third}).ok());
  EXPECT_TRUE(csv->row({0.1, tiny}).ok());
  EXPECT_EQ(content(file), "time,value\n0,0.3333333333333333\n0.1,5e-324\n");
  EXPECT_EQ(csv->column_count(), 2U);
  EXPECT_EQ(std::stod("0.3333333333333333"), third);
}

/// A file may not grow beyond a few bytes while this lives, as on a full disk.
class SmallFiles {
 public:
  explicit SmallFiles(rlim_t bytes) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit small{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &small);
    handler_ = std::signal(SIGXFSZ, SIG_IGN);
  }
  ~SmallFiles() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }
  SmallFiles(const SmallFiles&) = delete;
  SmallFiles& operator=(const SmallFiles&) = delete;

 private:
  rlimit before_{};
  void (*handler_)(int) = nullptr;
};

TEST_F(Io, ACsvRowThatDoesNotFitOnTheDiskIsAnError) {
  const auto file = folder_ / "series.csv";
  auto csv = CsvWriter::create(file, {"time"});
  ASSERT_TRUE(csv.ok());
  Result<void> second, third;
  {
    const SmallFiles full(9);
    EXPECT_TRUE(csv->row({1.5}).ok());
    second = csv->row({2.5});
  }
  third = csv->row({3.5});
  ASSERT_FALSE(second.ok());
  EXPECT_THAT(second.error().message, HasSubstr(file.string()));
  EXPECT_FALSE(third.ok()) << "a series with a hole is not a series";
  EXPECT_EQ(content(file), "time\n1.5\n");
  EXPECT_FALSE(CsvWriter::create("/dev/full", {"time"}).ok());
}

State sample() {
  State state{"structure", "0123456789abcdef", 0.1, 7, {}};
  state.add("displacement", {2, 3}, {0.1, -0.0, 1e-310, 3, std::numeric_limits<double>::max(), 1.0 / 3});
  state.add("empty", {0, 3}, {});
  state.add("scalar", {}, {42});
  return state;
}

TEST_F(Io, StateRoundTripIsExact) {
  const auto file = folder_ / "s.state";
  ASSERT_TRUE(write_state(file, sample()).ok());
  const auto read = read_state(file);
  ASSERT_TRUE(read.ok()) << read.error().message;
  const State expected = sample();
  EXPECT_EQ(read->kind, expected.kind);
  EXPECT_EQ(read->mesh_hash, expected.mesh_hash);
  EXPECT_EQ(read->time, expected.time);
  EXPECT_EQ(read->step, expected.step);
  ASSERT_EQ(read->arrays.size(), expected.arrays.size());
  for (std::size_t i = 0; i < expected.arrays.size(); ++i) {
    EXPECT_EQ(read->arrays[i].name, expected.arrays[i].name);
    EXPECT_EQ(read->arrays[i].shape, expected.arrays[i].shape);
    ASSERT_EQ(read->arrays[i].values.size(), expected.arrays[i].values.size());
    const std::size_t bytes = sizeof(double) * expected.arrays[i].values.size();
    EXPECT_TRUE(bytes == 0 ||
                std::memcmp(read->arrays[i].values.data(), expected.arrays[i].values.data(), bytes) == 0);
  }
  EXPECT_EQ(read->find("nothing"), nullptr);
  EXPECT_EQ(read->find("scalar")->values[0], 42);
}

TEST_F(Io, EveryTruncationOfAStateIsRefused) {
  const auto file = folder_ / "s.state";
  ASSERT_TRUE(write_state(file, sample()).ok());
  const std::string whole = content(file);
  for (std::size_t length = 0; length < whole.size(); ++length) {
    std::ofstream(file, std::ios::binary | std::ios::trunc) << whole.substr(0, length);
    const auto read = read_state(file);
    ASSERT_FALSE(read.ok()) << "accepted " << length << " of " << whole.size() << " bytes";
    EXPECT_EQ(read.error().kind, ErrorKind::config);
    EXPECT_THAT(read.error().message, HasSubstr("s.state"));
  }
  std::ofstream(file, std::ios::binary | std::ios::trunc) << whole << 'x';
  EXPECT_THAT(read_state(file).error().message, HasSubstr("1 bytes after the last array"));
}

/// Flips one bit of every byte of the file, one at a time. A flip in a value is found by its checksum and
/// names the array; a flip in the header must never crash, hang, or take memory that the file does not fill.
TEST_F(Io, DamagedValuesAreRefused) {
  const auto file = folder_ / "s.state";
  ASSERT_TRUE(write_state(file, sample()).ok());
  const std::string whole = content(file);
  const std::size_t values = 7 * sizeof(double);
  for (std::size_t byte = 0; byte < whole.size(); ++byte) {
    std::string damaged = whole;
    damaged[byte] = static_cast<char>(damaged[byte] ^ (1 << (byte % 8)));
    std::ofstream(file, std::ios::binary | std::ios::trunc) << damaged;
    const auto read = read_state(file);
    if (byte < whole.size() - values) continue;
    ASSERT_FALSE(read.ok()) << "byte " << byte;
    EXPECT_THAT(read.error().message, HasSubstr("wrong checksum of array"));
  }
}

TEST_F(Io, StateErrorsSayWhatIsWrong) {
  EXPECT_THAT(read_state(folder_ / "none.state").error().message, HasSubstr("No such file"));
  const auto file = folder_ / "s.state";
  std::ofstream(file) << "something else entirely";
  EXPECT_THAT(read_state(file).error().message, HasSubstr("does not start with \"DRGS\""));
  std::ofstream(file) << std::string("DRGS\x02\x00\x00\x00\x00", 9);
  EXPECT_THAT(read_state(file).error().message, HasSubstr("version 2"));
  std::ofstream(file) << std::string("DRGS\x01\xff\xff\xff\xff", 9);
  EXPECT_THAT(read_state(file).error().message, HasSubstr("a header of 4294967295 bytes"));
  State wrong = sample();
  wrong.arrays[0].values.pop_back();
  EXPECT_THAT(write_state(file, wrong).error().message, HasSubstr("does not fill its shape"));
}

TEST_F(Io, VtuRefusesArraysOfTheWrongLength) {
  const std::vector<double> points(9, 0.5);
  const std::vector<double> values(2, 1.0);
  const mesh::ElementBlock block{"wall", mesh::ElementKind::tri3, {0, 1, 2}};
  const VtuData data{points, {&block}, {{"pressure", 1, values}}, {}};
  const auto result = write_vtu(folder_ / "wrong.vtu", data);
  ASSERT_FALSE(result.ok());
  EXPECT_THAT(result.error().message, HasSubstr("array \"pressure\": 2 values for 3 PointData"));
  EXPECT_EQ(files_in_folder(), 0U);
}

TEST_F(Io, SeriesAndCollectionsGoOnFromAnEarlierPosition) {
  const auto run = [&](Existing existing, int first, int last, bool save, bool restore) {
    auto csv = CsvWriter::create(folder_ / "run/a.csv", {"step"}, existing);
    ASSERT_TRUE(csv.ok());
    PvdCollection collection(folder_ / "run/a.pvd");
    const ResultFiles files{{&*csv}, {&collection}};
    if (restore) {
      const auto restored = restore_positions(folder_ / "at_3.state", files);
      ASSERT_TRUE(restored.ok()) << restored.error().message;
    }
    for (int step = first; step <= last; ++step) {
      ASSERT_TRUE(csv->row({0.1 * step}).ok());
      ASSERT_TRUE(collection.add(0.1 * step, folder_ / fmt::format("run/a_{}.vtu", step)).ok());
      if (save && step == 3) {
        ASSERT_TRUE(save_positions(folder_ / "at_3.state", files).ok());
      }
    }
  };
  run(Existing::replace, 1, 6, true, false);
  const std::string csv = content(folder_ / "run/a.csv"), pvd = content(folder_ / "run/a.pvd");
  run(Existing::keep, 4, 5, false, true);
  EXPECT_LT(content(folder_ / "run/a.csv").size(), csv.size());
  run(Existing::keep, 4, 6, false, true);
  EXPECT_EQ(content(folder_ / "run/a.csv"), csv);
  EXPECT_EQ(content(folder_ / "run/a.pvd"), pvd);
}

TEST_F(Io, APositionBehindTheEndOfAFileIsRefused) {
  auto csv = CsvWriter::create(folder_ / "a.csv", {"step"});
  ASSERT_TRUE(csv.ok());
  PvdCollection collection(folder_ / "a.pvd");
  const ResultFiles files{{&*csv}, {&collection}};
  ASSERT_TRUE(csv->row({1.0}).ok() && collection.add(1, folder_ / "a_1.vtu").ok());
  ASSERT_TRUE(save_positions(folder_ / "late.state", files).ok());
  std::filesystem::remove(folder_ / "a.pvd");
  EXPECT_THAT(restore_positions(folder_ / "late.state", files).error().message,
              HasSubstr("a.pvd names 0 files, fewer than the 1"));
  ASSERT_TRUE(csv->cut(5).ok()); // the header
  EXPECT_THAT(restore_positions(folder_ / "late.state", files).error().message,
              HasSubstr("a.csv has 5 bytes, less than the 7"));
  auto other = CsvWriter::create(folder_ / "b.csv", {"step"});
  ASSERT_TRUE(other.ok());
  EXPECT_THAT(restore_positions(folder_ / "late.state", {{&*other}, {}}).error().message,
              HasSubstr("does not say how far"));
}

TEST_F(Io, PvdStoresRelativePaths) {
  PvdCollection collection(folder_ / "all.pvd");
  ASSERT_TRUE(collection.add(0.1, folder_ / "fields" / "a&b_0.vtu").ok());
  const std::string one = content(collection.file());
  EXPECT_THAT(one, HasSubstr("timestep=\"0.1\" part=\"0\" file=\"fields/a&amp;b_0.vtu\""));
  EXPECT_THAT(one, HasSubstr("</VTKFile>"));
  ASSERT_TRUE(collection.add(0.2, folder_ / "fields" / "a&b_1.vtu").ok());
  EXPECT_THAT(content(collection.file()), HasSubstr("timestep=\"0.2\""));
}

} // namespace
} // namespace drogue::io
