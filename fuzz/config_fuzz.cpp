// SPDX-License-Identifier: GPL-3.0-or-later
// Config texts: the first byte picks the schema, the rest is the text. What is not reported as an error can
// be used.

#include "common/config/config.hpp"
#include "common/config/expression.hpp"
#include "drogue/v1/coupler.pb.h"
#include "drogue/v1/fluid.pb.h"
#include "drogue/v1/mesh_mover.pb.h"
#include "drogue/v1/parachute_mesher.pb.h"
#include "drogue/v1/structure.pb.h"
#include "fuzz/scratch_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace drogue;
  if (size == 0) return 0;
  const auto file = fuzz::put("config.textproto", data + 1, size - 1);
  const auto load = [&](google::protobuf::Message&& message) {
    config::Report report;
    const config::Source source = config::load(file, message, report);
    (void)source.where("time.step");
    (void)source.where("boundary[2].name");
  };
  switch (data[0] % 5) {
  case 0:
    load(v1::CaseConfig());
    break;
  case 1:
    load(v1::FluidConfig());
    break;
  case 2:
    load(v1::StructureConfig());
    break;
  case 3:
    load(v1::MeshMoverConfig());
    break;
  default:
    if (const auto expression =
            config::Expression::parse({reinterpret_cast<const char*>(data + 1), size - 1}))
      (void)(*expression)(0.5, -1, 2, 0.1);
  }
  return 0;
}
