#include "apps/log_event.h"

#include <string>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

namespace pleinair {

void LogEvent(const Event& event) {
  const bool is_usual = event.kind == EventKind::kStarted || event.kind == EventKind::kPreparing ||
                        event.kind == EventKind::kPrepared || event.kind == EventKind::kEnded;
  spdlog::log(is_usual ? spdlog::level::info : spdlog::level::warn,
              "{}: {}{}",
              NameOf(event.kind),
              event.text,
              event.count > 1 ? fmt::format(" ({} frames)", event.count) : std::string());
}

}  // namespace pleinair
