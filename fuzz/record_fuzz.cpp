// SPDX-License-Identifier: GPL-3.0-or-later
// Records of runs, as `coupler replay` reads them.
#include "coupler/record/record_file.hpp"
#include "fuzz/scratch_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  auto reader = drogue::coupler::record::Reader::open(drogue::fuzz::put("fuzz.record", data, size));
  while (reader) {
    const auto entry = reader->next();
    if (!entry || !*entry) break;
  }
  return 0;
}
