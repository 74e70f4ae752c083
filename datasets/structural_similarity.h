// Structural similarity of two pictures (Wang, Bovik, Sheikh and Simoncelli, Image Quality
// Assessment: From Error Visibility to Structural Similarity, 2004).
#pragma once

#include <glm/vec3.hpp>

#include "scene/image.h"

namespace pleinair {

// Pixels [left, right) x [top, bottom).
struct PixelBox {
  int left = 0;
  int top = 0;
  int right = 0;
  int bottom = 0;
  bool Empty() const { return left >= right || top >= bottom; }
};

// Returns the mean of the SSIM over the box's pixels, of the luma (ITU-R BT.601) of code values 0
// .. 255; 1 for equal pictures. The window is a Gaussian of standard deviation 1.5 over 11 x 11
// pixels. It extends beyond the box, and is mirrored at the picture's border. Constants are 0.01
// and 0.03. Both pictures have one size and contain the box, which is not empty. (QualitySSIM of
// OpenCV, in double.)
double StructuralSimilarity(const Image<glm::dvec3>& codes,
                            const Image<glm::dvec3>& reference_codes,
                            const PixelBox& box);

}  // namespace pleinair
