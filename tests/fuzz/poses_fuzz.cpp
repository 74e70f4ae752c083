// Lines of camera poses, and what lies between them.
#include "datasets/pose_lines.h"

#include "tests/fuzz/fuzz_input.h"

using pleinair::TemporaryFolder;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const TemporaryFolder folder;
  const auto file = FuzzFile("poses.jsonl", data, size, folder);
  return pleinair::ReadsOrRefuses([&] {
    const pleinair::PoseTrack track = pleinair::ReadPoses(file);
    static_cast<void>(track.At(track.LatestTime()));
    static_cast<void>(track.At(pleinair::UtcTime{}));
  });
}
