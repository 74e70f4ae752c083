// Exposures in the EXIF data of a picture.
#include "calib/exif_exposure.h"

#include "tests/fuzz/fuzz_input.h"

using pleinair::TemporaryFolder;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const TemporaryFolder folder;
  const auto file = FuzzFile("picture.jpg", data, size, folder);
  return pleinair::ReadsOrRefuses([&] { pleinair::ReadExifExposure(file).RelativeExposure(); });
}
