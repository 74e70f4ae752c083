// The lighting.jsonl of a run.
#include "datasets/lighting_record.h"

#include "tests/fuzz/fuzz_input.h"

using pleinair::TemporaryFolder;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const TemporaryFolder folder;
  const auto file = FuzzFile("lighting.jsonl", data, size, folder);
  return pleinair::ReadsOrRefuses([&] { pleinair::ReadLightingRecords(file); });
}
