// Where a sequence's diffuse surfaces may be sampled: the image that `diffuse_mask` names.
#pragma once

#include <filesystem>
#include <optional>

#include "datasets/sequence.h"
#include "scene/image.h"

namespace pleinair {

struct DiffuseMask {
  Gray8Image image;  // 255: may be sampled.
  // Over the survey map; else over the picture of the camera in the first frame.
  bool is_over_map = false;
};

// A sequence with a survey map has its mask over that, unless the mask has the camera's size and
// not a map's proportions, 2 to 1. None where none is named. Throws std::runtime_error naming the
// file where it cannot be read.
std::optional<DiffuseMask> ReadDiffuseMask(const Sequence& sequence);

// Makes `mask`, over the first frame of `sequence`, that of its file, together with the one over
// the first frame that it has: of each pixel the darker. It is written as diffuse_mask.png, or as
// the file that the key names; the file before the key. Returns its path. Of `sequence` only the
// file counts, which is read again.
//
// Throws  std::runtime_error, one line, naming the file: where a mask over the survey map is there,
//         for a mask of another size than the camera's, as ReadSequence, and as EditSiteFile.
std::filesystem::path SaveDiffuseMask(const Sequence& sequence, Gray8Image mask);

// The same, in place of the one that it has.
std::filesystem::path ReplaceDiffuseMask(const Sequence& sequence, const Gray8Image& mask);

}  // namespace pleinair
