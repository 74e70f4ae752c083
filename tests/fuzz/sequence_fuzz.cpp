// sequence.json, and as a site.
#include "datasets/sequence.h"

#include "tests/fuzz/fuzz_input.h"

using pleinair::TemporaryFolder;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const TemporaryFolder folder;
  // What the seeds name must exist; only the calibration is read.
  static const bool has_files = [] {
    for (const char* name : {"scene.obj", "object.obj", "environment.exr", "mask.png"}) {
      folder.Write(name, "x");
    }
    folder.Write("fisheye.json",
                 R"({"format": "pleinair-fisheye", "version": 1, "model": "equidistant",
                     "width": 512, "height": 500, "fx": 159, "fy": 159, "cx": 255.5, "cy": 249.5,
                     "fov_deg": 180})");
    return true;
  }();
  if (has_files) FuzzFile("sequence.json", data, size, folder);
  pleinair::ReadsOrRefuses([] { pleinair::ReadSite(folder.Path(), pleinair::UtcTime()); });
  return pleinair::ReadsOrRefuses([] { pleinair::ReadSequence(folder.Path()); });
}
