// OpenSfM's reconstruction.json.
#include "datasets/reconstruction/reconstruction_file.h"
#include "tests/fuzz/fuzz_input.h"

using pleinair::TemporaryFolder;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const TemporaryFolder folder;
  const auto file = FuzzFile("reconstruction.json", data, size, folder);
  return pleinair::ReadsOrRefuses([&] {
    const pleinair::Reconstruction read = pleinair::ReadOpenSfm(file);
    for (std::size_t i = 0; i < read.pictures.size(); ++i) pleinair::VisiblePoints(read, i);
  });
}
