#include "datasets/video/internal/libav_functions.h"

#include <stdexcept>

#include <dlfcn.h>
#include <fmt/format.h>

namespace pleinair {

void* FindLibavFunction(const char* library, const char* function) {
  // Never unloaded: other libraries' threads and handlers may stay behind.
  void* const loaded = dlopen(library, RTLD_LAZY | RTLD_LOCAL);
  if (loaded == nullptr) {
    throw std::runtime_error(fmt::format(
        "{}: expected FFmpeg's library, which videos need, found none ({})", library, dlerror()));
  }
  void* const address = dlsym(loaded, function);
  if (address == nullptr) {
    throw std::runtime_error(
        fmt::format("{}: expected FFmpeg's function {}, found none", library, function));
  }
  return address;
}

}  // namespace pleinair
