// OpenEXR and Radiance pictures.
#include "scene/image_io.h"
#include "tests/fuzz/fuzz_input.h"

using pleinair::TemporaryFolder;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const TemporaryFolder folder;
  const auto file = FuzzFile("radiance", data, size, folder);
  return pleinair::ReadsOrRefuses([&] {
    pleinair::RgbImage image = pleinair::ReadRadianceImage(file);
    pleinair::RepairRadiance(image);
    if (pleinair::DefectsOf(image).Count() != 0) std::abort();
  });
}
