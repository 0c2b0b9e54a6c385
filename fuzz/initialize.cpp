// SPDX-License-Identifier: GPL-3.0-or-later
// What all fuzzers do first: nothing is logged about inputs that are wrong on purpose.
#include <google/protobuf/stubs/logging.h>
#include <spdlog/spdlog.h>

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  google::protobuf::SetLogHandler(nullptr);
  spdlog::set_level(spdlog::level::off);
  return 0;
}
