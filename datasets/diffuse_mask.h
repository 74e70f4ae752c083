// Where a sequence's diffuse surfaces may be sampled: the image that `diffuse_mask` names.
#pragma once

#include <filesystem>
#include <optional>

#include "datasets/sequence.h"
#include "scene/image.h"

namespace pleinair {

// A mask, and the picture that it is over.
struct DiffuseMask {
  Gray8Image image;  // 255: may be sampled.
  // Over the survey map; else over the picture of the camera in the first frame.
  bool is_over_map = false;
};

// Returns the mask of a sequence. With a survey map it is over that, unless it has the camera's
// size and not a map's proportions, 2 to 1. None where none is named. Throws std::runtime_error
// naming the file where it cannot be read.
std::optional<DiffuseMask> ReadDiffuseMask(const Sequence& sequence);

// Adds `mask`, over the first frame of `sequence`, to the sequence's own mask over that frame: the
// darker pixel of both counts. It is written as diffuse_mask.png, or as the file that the key
// names, before the key is written. Returns its path. `sequence` gives only the file, which is read
// again.
//
// Throws  std::runtime_error, one line, naming the file: where the sequence has a mask over the
//         survey map, for a mask of another size than the camera's, as ReadSequence, and as
//         EditSiteFile.
std::filesystem::path SaveDiffuseMask(const Sequence& sequence, Gray8Image mask);

// The same, but replaces the sequence's own mask.
std::filesystem::path ReplaceDiffuseMask(const Sequence& sequence, const Gray8Image& mask);

}  // namespace pleinair
