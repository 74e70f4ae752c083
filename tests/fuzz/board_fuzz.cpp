// A board of markers.
#include "calib/marker_board.h"

#include "tests/fuzz/fuzz_input.h"

using pleinair::TemporaryFolder;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const TemporaryFolder folder;
  const auto file = FuzzFile("board.json", data, size, folder);
  return pleinair::ReadsOrRefuses([&] { pleinair::ReadMarkerBoard(file); });
}
