// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/base/log.hpp"

#include <spdlog/sinks/stdout_color_sinks.h>

namespace drogue {

void start_log(const std::string& program) {
  auto logger =
      std::make_shared<spdlog::logger>(program, std::make_shared<spdlog::sinks::stderr_color_sink_mt>());
  logger->set_pattern("%H:%M:%S.%e %n %^%l%$  %v");
  logger->flush_on(spdlog::level::info);
  spdlog::set_default_logger(std::move(logger));
}

} // namespace drogue
