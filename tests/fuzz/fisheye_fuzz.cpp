// A fish-eye camera's calibration.
#include "calib/fisheye_file.h"

#include "tests/fuzz/fuzz_input.h"

using pleinair::TemporaryFolder;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const TemporaryFolder folder;
  const auto file = FuzzFile("fisheye.json", data, size, folder);
  return pleinair::ReadsOrRefuses([&] { pleinair::ReadFisheyeCalibration(file); });
}
