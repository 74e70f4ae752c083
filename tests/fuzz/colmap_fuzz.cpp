// COLMAP's models: the first byte says which of the six files the others are; the rest of the model
// is sound.
#include <array>
#include <cmath>

#include "calib/reconstruction/surfaces.h"
#include "datasets/reconstruction/reconstruction_file.h"
#include "tests/datasets/colmap_files.h"
#include "tests/fuzz/fuzz_input.h"

using pleinair::TemporaryFolder;

namespace {

constexpr std::array kFiles = {
    "cameras.bin", "images.bin", "points3D.bin", "cameras.txt", "images.txt", "points3D.txt"};
constexpr std::size_t kBinaryFiles = 3;

// What is read holds what is promised, and can be worked on.
void Use(const pleinair::Reconstruction& read) {
  for (const pleinair::ReconstructedPicture& picture : read.pictures) {
    if (picture.camera >= read.cameras.size()) std::abort();
    if (!std::isfinite(glm::dot(picture.Centre(), picture.Centre()))) std::abort();
    for (const pleinair::PointObservation& seen : picture.observations) {
      if (seen.point >= read.points.size()) std::abort();
    }
  }
  pleinair::FitSurfaces(read, {}, {});
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const TemporaryFolder binary;
  static const TemporaryFolder text;
  if (size == 0) return 0;
  const std::size_t file = data[0] % kFiles.size();
  const bool is_binary = file < kBinaryFiles;
  const TemporaryFolder& folder = is_binary ? binary : text;
  if (is_binary) {
    pleinair::WriteColmapBinary(pleinair::SmallColmapModel(), folder);
  } else {
    pleinair::WriteColmapText(pleinair::SmallColmapModel(), folder);
  }
  FuzzFile(kFiles[file], data + 1, size - 1, folder);
  return pleinair::ReadsOrRefuses([&] { Use(pleinair::ReadColmap(folder.Path())); });
}
