// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <csignal>
#include <map>
#include <thread>

#include "coupler/launcher/process.hpp"
#include "tests/support/coupled_case.hpp"

/// Helpers of the tests that interrupt and resume coupled runs. A case stands in `folder`, its run in
/// folder/run.
namespace drogue::test {

inline launcher::Process start_program(const std::filesystem::path& folder,
                                       const std::vector<std::string>& arguments) {
  std::vector<std::string> command{std::string(DROGUE_BIN_DIR) + "/coupler"};
  command.insert(command.end(), arguments.begin(), arguments.end());
  std::filesystem::remove(folder / "output.txt");
  auto process = launcher::Process::start({command, {}, folder, folder / "output.txt"});
  EXPECT_TRUE(process.ok());
  return std::move(*process);
}

/// Status of `coupler ARGUMENTS`; its output in folder/output.txt. -1: it did not end.
inline int run_coupler_with(const std::filesystem::path& folder, const std::vector<std::string>& arguments) {
  launcher::Process process = start_program(folder, arguments);
  const auto& exit = process.wait(std::chrono::minutes(4));
  return exit ? exit->status : -1;
}

/// Waits until a condition holds; false after `seconds`.
template <class Condition>
bool eventually(Condition condition, double seconds = 60) {
  for (int i = 0; i < 100 * seconds; ++i) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

inline std::filesystem::path checkpoint_folder(const std::filesystem::path& folder, int step) {
  return folder / "run/checkpoints" / fmt::format("{:08}", step);
}
inline bool has_checkpoint(const std::filesystem::path& folder, int step) {
  return std::filesystem::exists(checkpoint_folder(folder, step) / "manifest.textproto");
}

/// Whether a collection beside it names a .vtu file. A solver that is stopped may write its last state, of
/// which a resumed run knows nothing any more.
inline bool in_a_collection(const std::filesystem::path& vtu) {
  for (const auto& entry : std::filesystem::directory_iterator(vtu.parent_path()))
    if (entry.path().extension() == ".pvd" &&
        read_text(entry.path()).find(vtu.filename().string()) != std::string::npos)
      return true;
  return false;
}

/// Content of all results (*.csv, *.pvd, *.vtu of a collection) of a run by their names, and of the files of
/// its checkpoint of `step` but the manifest, which names paths.
inline std::map<std::string, std::string> everything(const std::filesystem::path& folder, int step) {
  namespace fs = std::filesystem;
  std::map<std::string, std::string> content;
  for (const auto& entry : fs::recursive_directory_iterator(folder / "run")) {
    const std::string name = entry.path().lexically_relative(folder / "run"), type = entry.path().extension();
    if (type == ".csv" || type == ".pvd" || (type == ".vtu" && in_a_collection(entry.path())))
      content[name] = read_text(entry.path());
  }
  for (const auto& entry : fs::recursive_directory_iterator(checkpoint_folder(folder, step)))
    if (entry.is_regular_file() && entry.path().filename() != "manifest.textproto")
      content[entry.path().lexically_relative(folder / "run")] = read_text(entry.path());
  return content;
}

inline void expect_same(const std::map<std::string, std::string>& a,
                        const std::map<std::string, std::string>& b) {
  for (const auto& [name, text] : a) {
    ASSERT_TRUE(b.count(name)) << name << " is missing";
    EXPECT_TRUE(text == b.at(name)) << name << " differs";
  }
  EXPECT_EQ(a.size(), b.size());
}

} // namespace drogue::test
