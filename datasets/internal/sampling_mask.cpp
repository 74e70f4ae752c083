#include "datasets/internal/sampling_mask.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>

#include "datasets/internal/sequence_folder.h"
#include "scene/image_io.h"

namespace pleinair {
namespace {

constexpr std::uint8_t kMaySample = 255;

}  // namespace

SamplingMask::SamplingMask(const Sequence& sequence) : sequence_(sequence) {
  if (!sequence.diffuse_mask || sequence.environment) return;
  const std::filesystem::path file = FileInside(sequence.folder, *sequence.diffuse_mask);
  mask_ = ReadMaskImage(file);
  RequireCameraSize(*mask_, sequence.intrinsics, "camera", file);
}

void SamplingMask::ApplyTo(Frame& frame) const {
  if (!mask_ || !(frame.camera == sequence_.CameraOfFrame(0))) return;
  for (std::size_t i = 0; i < frame.unusable.pixels.size(); ++i) {
    if (mask_->pixels[i] != kMaySample) frame.unusable.pixels[i] = kUnusable;
  }
}

}  // namespace pleinair
