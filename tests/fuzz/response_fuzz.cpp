// A camera's response curve.
#include "calib/response.h"

#include "tests/fuzz/fuzz_input.h"

using pleinair::TemporaryFolder;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const TemporaryFolder folder;
  const auto file = FuzzFile("response.json", data, size, folder);
  return pleinair::ReadsOrRefuses([&] { pleinair::ResponseCurve::FromFile(file); });
}
