#include "datasets/diffuse_mask.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include <nlohmann/json.hpp>

#include "datasets/internal/sequence_folder.h"
#include "datasets/site_file.h"
#include "scene/image_io.h"
#include "scene/whole_file.h"

namespace pleinair {
namespace {

// The file's present content: a caller's sequence may lack parts that its settings leave out, the
// survey map and its mask.
Sequence AsWritten(const Sequence& sequence) {
  return sequence.file.filename() == "site.json"
             ? ReadSite(sequence.folder, UtcTime{}, SequencePoses::kMayBeAbsent)
             : ReadSequence(sequence.folder, SequencePoses::kMayBeAbsent);
}

}  // namespace

std::optional<DiffuseMask> ReadDiffuseMask(const Sequence& sequence) {
  if (!sequence.diffuse_mask) return std::nullopt;
  DiffuseMask mask{ReadMaskImage(FileInside(sequence.folder, *sequence.diffuse_mask))};
  const bool has_pictures_size = mask.image.width == sequence.intrinsics.width_px &&
                                 mask.image.height == sequence.intrinsics.height_px;
  const bool has_maps_shape = mask.image.width == 2 * mask.image.height;
  mask.is_over_map = sequence.environment && (has_maps_shape || !has_pictures_size);
  return mask;
}

std::filesystem::path SaveDiffuseMask(const Sequence& caller, Gray8Image mask) {
  const Sequence sequence = AsWritten(caller);
  RequireCameraSize(mask, sequence.intrinsics, "camera", "the mask");
  const auto known = ReadDiffuseMask(sequence);
  if (known && !known->is_over_map) {
    RequireCameraSize(
        known->image, sequence.intrinsics, "camera", sequence.folder / *sequence.diffuse_mask);
    for (std::size_t i = 0; i < mask.pixels.size(); ++i) {
      mask.pixels[i] = std::min(mask.pixels[i], known->image.pixels[i]);
    }
  }
  return ReplaceDiffuseMask(sequence, mask);
}

std::filesystem::path ReplaceDiffuseMask(const Sequence& caller, const Gray8Image& mask) {
  const Sequence sequence = AsWritten(caller);
  RequireCameraSize(mask, sequence.intrinsics, "camera", "the mask");
  if (const auto known = ReadDiffuseMask(sequence); known && known->is_over_map) {
    RefuseFile(sequence.file,
               "diffuse_mask is over the survey map, and there is no place for another one over "
               "the first frame");
  }
  if (!sequence.diffuse_mask && sequence.environment && mask.width == 2 * mask.height) {
    RefuseFile(sequence.file,
               "a mask of these pictures, twice as wide as high, would be one over the survey map");
  }
  const std::filesystem::path name = sequence.diffuse_mask.value_or("diffuse_mask.png");
  WritePng(sequence.folder / name, mask);
  EditSiteFile(sequence.file,
               [&](nlohmann::ordered_json& json) { json["diffuse_mask"] = name.string(); });
  return sequence.folder / name;
}

}  // namespace pleinair
