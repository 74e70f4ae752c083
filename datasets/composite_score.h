// Compares a composite with the picture of the scene that really contains the object.
//
// All comparisons use display values: 255 sRGB(clip(radiance exposure)), not rounded to whole code
// values.
#pragma once

#include <optional>

#include "scene/image.h"

namespace pleinair {

// Value for an exact match, whose PSNR is infinite.
inline constexpr double kHighestPsnrDb = 100.0;
// Least effect of an object on a pixel that it does not cover.
inline constexpr double kEffectCodes = 2.0;
// Largest change of an unchanged pixel.
inline constexpr double kUnchangedCodes = 1.0;

// All of one size. Pointers may be null where it says so.
struct CompositePictures {
  const RgbImage& input;           // The frame that the composite was made from.
  const RgbImage& composite;       // As written, in half precision.
  const RgbImage& without_object;  // The frame at its best: linear where there is a linear one.
  const RgbImage& with_object;     // The truth.
  const Gray8Image& coverage;      // 0..255: share of the pixel that the object covers.
  const Gray8Image* change;        // The composite's own mask, 0 for unchanged pixels; or null.
  const Gray8Image* specular;      // Not 0 where the object mirrors; null where it does not mirror.
  double exposure = 1.0;
};

// The score of one composite, on display code values 0..255.
struct CompositeScore {
  // Over pixels that the object covers completely.
  std::optional<double> object_psnr_db;
  // The same without pixels of a mirroring material; none where there is no such material.
  std::optional<double> object_psnr_without_specular_db;
  // Over pixels that the object changes by more than kEffectCodes without touching them.
  std::optional<double> effect_psnr_db;
  // Structural similarity over the box around the pixels that the object covers or, by more than
  // kEffectCodes, changes. None where there is no such pixel.
  std::optional<double> similarity;
  // Share of the pixels outside the composite's own mask that equal the input, rounded to half
  // precision, bit for bit. None without a mask.
  std::optional<double> identical_outside_mask;
  // Share of the pixels unchanged in truth that the composite changes by more than kUnchangedCodes.
  std::optional<double> changed_of_unchanged;
  int object_pixels = 0;
  int effect_pixels = 0;
};

// Throws std::invalid_argument where sizes differ or the exposure is not positive.
CompositeScore ScoreComposite(const CompositePictures& pictures);

// Rounds each value to half precision, as a composite is written.
RgbImage RoundToHalf(RgbImage image);

// How many pixels of the composite are the input's, rounded to half precision.
int CountIdenticalPixels(const RgbImage& input, const RgbImage& composite);

}  // namespace pleinair
