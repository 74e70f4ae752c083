#include "session/available_memory.h"

#include <algorithm>
#include <fstream>
#include <limits>
#include <stdexcept>
#include <string>

#include <fmt/format.h>

namespace pleinair {
namespace {

constexpr std::size_t kUnlimited = std::numeric_limits<std::size_t>::max();
constexpr double kGiB = 1024.0 * 1024.0 * 1024.0;

// Linux's MemAvailable; see proc(5).
std::size_t MemAvailableBytes() {
  std::ifstream file("/proc/meminfo");
  std::string name;
  std::string rest;
  std::size_t kib = 0;
  while (file >> name >> kib && std::getline(file, rest)) {
    if (name == "MemAvailable:") return 1024 * kib;
  }
  return 0;
}

// A number in a file of the control group (version 2); kUnlimited where there is none.
std::size_t ControlGroupBytes(const char* path) {
  std::ifstream file(path);
  std::size_t bytes = 0;
  return file >> bytes ? bytes : kUnlimited;
}

}  // namespace

std::size_t AvailableMemoryBytes() {
  const std::size_t of_system = MemAvailableBytes();
  const std::size_t limit = ControlGroupBytes("/sys/fs/cgroup/memory.max");
  const std::size_t used = ControlGroupBytes("/sys/fs/cgroup/memory.current");
  if (limit == kUnlimited || used == kUnlimited) return of_system;
  const std::size_t of_group = limit - std::min(limit, used);
  return of_system == 0 ? of_group : std::min(of_system, of_group);
}

void RequireMemory(std::size_t bytes, const char* what, const char* remedy) {
  const std::size_t available = AvailableMemoryBytes();
  if (available == 0 || bytes <= available) return;
  throw std::runtime_error(fmt::format("{} may take {:.1f} GiB of memory, {:.1f} are there: {}",
                                       what,
                                       static_cast<double>(bytes) / kGiB,
                                       static_cast<double>(available) / kGiB,
                                       remedy));
}

}  // namespace pleinair
