// Replays inputs where there is no libFuzzer: seeds and what once crashed.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <vector>

#include "tests/fuzz/fuzz_input.h"

int main(int argc, char** argv) {
  std::vector<std::filesystem::path> inputs;
  for (int i = 1; i < argc; ++i) {
    for (const auto& entry : std::filesystem::directory_iterator(argv[i])) {
      inputs.push_back(entry.path());
    }
  }
  std::sort(inputs.begin(), inputs.end());
  for (const std::filesystem::path& input : inputs) {
    // Before it is read: where it crashes, its name is the last line.
    std::printf("%s\n", input.c_str());
    std::fflush(stdout);
    const std::string bytes = pleinair::ContentOf(input);
    LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
  }
  if (inputs.empty()) std::fprintf(stderr, "no inputs: expected folders with files\n");
  return inputs.empty() ? 1 : 0;
}
