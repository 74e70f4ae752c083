// What all fuzz targets share: bytes in a file of a folder of the process's own.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string_view>

#include "tests/scene/temporary_folder.h"

// Of libFuzzer: one input. A target is this function, in a program of its own.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace pleinair {

// The file `name` with these bytes, among what else the target has written there.
inline std::filesystem::path FuzzFile(const std::filesystem::path& name,
                                      const std::uint8_t* data,
                                      std::size_t size,
                                      const TemporaryFolder& folder) {
  return folder.Write(name.string(), {reinterpret_cast<const char*>(data), size});
}

// Readers promise a result or a std::runtime_error: all else, std::bad_alloc too, is a finding.
template <class Read>
int ReadsOrRefuses(const Read& read) {
  try {
    read();
  } catch (const std::runtime_error&) {
  }
  return 0;
}

}  // namespace pleinair
