#include "datasets/composite_score.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include <Imath/half.h>

#include "datasets/structural_similarity.h"
#include "scene/srgb.h"

namespace pleinair {
namespace {

double Code(float radiance, double exposure) {
  const double linear = static_cast<double>(radiance) * exposure;
  // Negated so that NaN is shown as black, as by a camera's writer.
  return !(linear > 0.0) ? 0.0 : 255.0 * SrgbFromLinear(std::min(linear, 1.0));
}

using Codes = Image<glm::dvec3>;

Codes CodesOf(const RgbImage& radiance, double exposure) {
  Codes codes(radiance.width, radiance.height);
  for (std::size_t i = 0; i < radiance.pixels.size(); ++i) {
    for (int c = 0; c < 3; ++c) codes.pixels[i][c] = Code(radiance.pixels[i][c], exposure);
  }
  return codes;
}

double LargestDifference(const glm::dvec3& a, const glm::dvec3& b) {
  return std::max({std::abs(a.x - b.x), std::abs(a.y - b.y), std::abs(a.z - b.z)});
}

bool IsIdentical(const glm::vec3& input, const glm::vec3& composite) {
  for (int c = 0; c < 3; ++c) {
    const float expected = static_cast<float>(Imath::half(input[c]));
    // NaN stays NaN; its bits do not matter.
    if (std::isnan(expected) && std::isnan(composite[c])) continue;
    if (expected != composite[c]) return false;
  }
  return true;
}

// Squared differences of code values, to a PSNR.
class PsnrSum {
 public:
  void Add(const glm::dvec3& a, const glm::dvec3& b) {
    const glm::dvec3 difference = a - b;
    sum_ += difference.x * difference.x + difference.y * difference.y + difference.z * difference.z;
    ++pixels_;
  }
  int Pixels() const { return pixels_; }
  std::optional<double> Psnr() const {
    if (pixels_ == 0) return std::nullopt;
    const double mean = sum_ / (3.0 * pixels_);
    if (!(mean > 0.0)) return kHighestPsnrDb;
    return std::min(kHighestPsnrDb, 10.0 * std::log10(255.0 * 255.0 / mean));
  }

 private:
  double sum_ = 0.0;
  int pixels_ = 0;
};

// Around the pixels that were added.
class BoxAround {
 public:
  void Add(int x, int y) {
    if (box_.Empty()) {
      box_ = {x, y, x + 1, y + 1};
      return;
    }
    box_ = {std::min(box_.left, x),
            std::min(box_.top, y),
            std::max(box_.right, x + 1),
            std::max(box_.bottom, y + 1)};
  }
  const PixelBox& Box() const { return box_; }

 private:
  PixelBox box_;
};

template <typename Pixel>
void RequireSize(const char* name, const Image<Pixel>& image, const RgbImage& input) {
  if (image.width == input.width && image.height == input.height) return;
  throw std::invalid_argument(std::string(name) + ": expected " + std::to_string(input.width) +
                              "x" + std::to_string(input.height) + " pixels as the frame, found " +
                              std::to_string(image.width) + "x" + std::to_string(image.height));
}

void RequireValid(const CompositePictures& pictures) {
  RequireSize("composite", pictures.composite, pictures.input);
  RequireSize("frame without the object", pictures.without_object, pictures.input);
  RequireSize("truth with the object", pictures.with_object, pictures.input);
  RequireSize("coverage", pictures.coverage, pictures.input);
  if (pictures.change) RequireSize("mask", *pictures.change, pictures.input);
  if (pictures.specular) RequireSize("specular mask", *pictures.specular, pictures.input);
  if (!(pictures.exposure > 0.0) || !std::isfinite(pictures.exposure)) {
    throw std::invalid_argument("exposure " + std::to_string(pictures.exposure) +
                                ": expected a positive number");
  }
}

}  // namespace

RgbImage RoundToHalf(RgbImage image) {
  for (glm::vec3& rgb : image.pixels) {
    for (int c = 0; c < 3; ++c) rgb[c] = static_cast<float>(Imath::half(rgb[c]));
  }
  return image;
}

int CountIdenticalPixels(const RgbImage& input, const RgbImage& composite) {
  RequireSize("composite", composite, input);
  int identical = 0;
  for (std::size_t i = 0; i < input.pixels.size(); ++i) {
    identical += IsIdentical(input.pixels[i], composite.pixels[i]) ? 1 : 0;
  }
  return identical;
}

CompositeScore ScoreComposite(const CompositePictures& pictures) {
  RequireValid(pictures);
  const Codes input = CodesOf(pictures.input, pictures.exposure);
  const Codes composite = CodesOf(pictures.composite, pictures.exposure);
  const Codes without_object = CodesOf(pictures.without_object, pictures.exposure);
  const Codes with_object = CodesOf(pictures.with_object, pictures.exposure);

  PsnrSum object;
  PsnrSum object_without_specular;
  PsnrSum effect;
  BoxAround touched;
  int outside_mask = 0;
  int identical_outside_mask = 0;
  int unchanged = 0;
  int changed_of_unchanged = 0;
  for (std::size_t i = 0; i < input.pixels.size(); ++i) {
    if (pictures.change && pictures.change->pixels[i] == 0) {
      ++outside_mask;
      identical_outside_mask +=
          IsIdentical(pictures.input.pixels[i], pictures.composite.pixels[i]) ? 1 : 0;
    }
    if (pictures.coverage.pixels[i] == 255) {
      object.Add(composite.pixels[i], with_object.pixels[i]);
      if (pictures.specular && pictures.specular->pixels[i] == 0) {
        object_without_specular.Add(composite.pixels[i], with_object.pixels[i]);
      }
    }
    const double true_change = LargestDifference(without_object.pixels[i], with_object.pixels[i]);
    if (pictures.coverage.pixels[i] != 0 || true_change > kEffectCodes) {
      const auto width = static_cast<std::size_t>(pictures.input.width);
      touched.Add(static_cast<int>(i % width), static_cast<int>(i / width));
    }
    // The object's edge is in neither set: half a pixel of geometry would decide there.
    if (pictures.coverage.pixels[i] != 0) continue;
    if (true_change > kEffectCodes) effect.Add(composite.pixels[i], with_object.pixels[i]);
    if (true_change <= kUnchangedCodes) {
      ++unchanged;
      changed_of_unchanged +=
          LargestDifference(input.pixels[i], composite.pixels[i]) > kUnchangedCodes ? 1 : 0;
    }
  }

  CompositeScore score;
  score.object_psnr_db = object.Psnr();
  score.object_psnr_without_specular_db = object_without_specular.Psnr();
  score.effect_psnr_db = effect.Psnr();
  if (!touched.Box().Empty()) {
    score.similarity = StructuralSimilarity(composite, with_object, touched.Box());
  }
  if (outside_mask > 0) {
    score.identical_outside_mask = static_cast<double>(identical_outside_mask) / outside_mask;
  }
  if (unchanged > 0) {
    score.changed_of_unchanged = static_cast<double>(changed_of_unchanged) / unchanged;
  }
  score.object_pixels = object.Pixels();
  score.effect_pixels = effect.Pixels();
  return score;
}

}  // namespace pleinair
