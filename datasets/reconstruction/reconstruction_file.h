// Reads reconstructions from photographs by COLMAP and OpenSfM.
#pragma once

#include <filesystem>

#include "calib/reconstruction/reconstruction.h"

namespace pleinair {

// COLMAP's model in `folder`: cameras, images and points3D, each as .bin or else as .txt.
//
// Cameras  SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV, and FULL_OPENCV whose
//          denominator is 1. COLMAP's pixels count from the corner; half a pixel is subtracted.
// Notes    observations of points that points3D does not hold.
// Throws   std::runtime_error, one line with file and what was expected. Refused are a file that is
//          absent, truncated or longer than its counts, a number that is not finite or absurd, a
//          camera that pleinair's lens does not express, no picture or no point. Memory is bounded
//          by some ten times the files' size.
Reconstruction ReadColmap(const std::filesystem::path& folder);

// OpenSfM's reconstruction.json; of several reconstructions the one with the most pictures, noted.
// It has no observations.
//
// Cameras  perspective, simple_radial, radial and brown.
// Place    where there is a reference_lla, the model is east-north-up about it.
// Throws   as above.
Reconstruction ReadOpenSfm(const std::filesystem::path& file);

// Either: a .json file or a folder with reconstruction.json is OpenSfM's; a folder with cameras.bin
// or cameras.txt COLMAP's.
Reconstruction ReadReconstruction(const std::filesystem::path& file_or_folder);

}  // namespace pleinair
