// The pixels that the light is estimated from: drawing them, and measuring them in each frame.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "estimation/diffuse_sample.h"
#include "scene/camera.h"
#include "scene/image.h"
#include "scene/pixel_rect.h"
#include "scene/surface_view.h"

namespace pleinair {

// How footprints are chosen among the strata of a SampleSet, and inside them.
enum class SampleChoice {
  kBalanced,      // Each stratum an equal share, spread evenly over it.
  kProportional,  // Each in proportion to its size: spread evenly over what is visible.
  kRandom,        // As proportional, but at random inside a stratum.
};

// How many samples are drawn, and how.
struct SampleSelectionOptions {
  int samples = 500;  // At most; fewer where the view has fewer. 1 .. 100000.
  std::uint64_t seed = 1;
  SampleChoice choice = SampleChoice::kBalanced;
  // Throws std::invalid_argument naming field and value.
  void Validate() const;
};

// A footprint and its model.
struct SampleFootprint {
  int x = 0;
  int y = 0;
  int radius = 0;
  int stride = 1;
  std::int32_t plane = 0;
  bool is_lit = false;
  glm::vec3 place_world_m{0.0f};  // Where it was drawn.
  double weight = 1.0;
  // Means over the footprint, RGB by row: albedo / pi * s * n, and albedo / pi * s_bounce.
  std::array<glm::dvec3, 3> direct{};
  glm::dvec3 bounce{0.0};
  std::array<glm::dvec3, kMaxSkyShapes> sky{};
  glm::dvec3 measured_albedo{0.0};  // 0 where it is not.
};

// A set of footprints in one view.
//
// A footprint is a square of pixels: half a survey texel or one pixel to each side of its centre,
// whichever is more. It lies inside one region and one plane, clear of every edge of the model.
// Pixels at grazing sun are left out (n.l below 0.1: there a degree of error changes the light by a
// sixth) where there are others: on flat ground under a low sun there are hardly any, and all are
// taken. So are those in a penumbra, and those whose albedo is an outlier of its region (windows,
// doors, plants). Where a person has judged whether the sun reaches a place, that judgement
// replaces the model's shadows; places judged as grazing are left out.
//
// Strata are region x lit or shaded x facing (the nearest of the six axes). Each gets an equal
// share, or the share of the chosen rule; what a small one cannot use goes to the others. Within a
// stratum the footprints are spread over the picture by the R2 sequence's ordered dither.
class SampleSet {
 public:
  // Draws a new set. Pixels that are kUnusable, or not finite in `radiance`, are not drawn; Measure
  // leaves out those that become so later. Pixels that are only kNearBlack are kept, since a mean
  // without them would be too bright. Clipped pixels are kept too: on a clipped surface the others
  // are panes and shadows that the mesh lacks. A pure function of its arguments.
  // Throws std::invalid_argument when the images' sizes differ from the view's, or when the view
  // has no sky response or more than kMaxSkyShapes.
  void Draw(const SurfaceView& view,
            const glm::dvec3& sun_direction_enu,
            const RgbImage& radiance,
            const Gray8Image& unusable,
            const SampleSelectionOptions& options);

  // For a camera that has moved: footprints move to where `view` shows the places that they were
  // drawn at. Those that it does not show, or shows too close to an edge, leave the set. So the
  // light is measured on the same surfaces from frame to frame. Their model is the view's. Returns
  // how many remain. A view of another size keeps none. Throws as Draw.
  int Follow(const SurfaceView& view,
             const glm::dvec3& sun_direction_enu,
             const RgbImage& radiance,
             const Gray8Image& unusable,
             const SampleSelectionOptions& options);
  // The pixels that Follow reads in a view of `camera`: one rectangle for each footprint whose
  // place lies in its picture.
  std::vector<PixelRect> PixelsFollowed(const Camera& camera) const;
  // Replaces those that have left: every stratum gets what it lacks. As Draw where the set is
  // empty.
  void Refill(const SurfaceView& view,
              const glm::dvec3& sun_direction_enu,
              const RgbImage& radiance,
              const Gray8Image& unusable,
              const SampleSelectionOptions& options);

  // Writes a sample for each footprint that is completely usable, and reuses the memory of
  // `samples`. The order is by plane, then row-major by pixel. A channel with a clipped pixel has
  // an infinite deviation: its mean is too dark. Returns how many footprints were left out. Throws
  // std::invalid_argument when the images' sizes differ from those of Draw.
  int Measure(const glm::dvec3& sun_direction_enu,
              const RgbImage& radiance,
              const Gray8Image& unusable,
              std::vector<DiffuseSample>& samples) const;

  int Size() const { return static_cast<int>(footprints_.size()); }
  // Whether another frame of the same view could fill the set better: it has fewer footprints than
  // asked for, and unusable pixels are among the reasons.
  bool IsShortOfUsablePixels() const { return short_of_usable_pixels_; }

 private:
  static void Prefetch(const SampleFootprint& footprint,
                       const RgbImage& radiance,
                       const Gray8Image& unusable);

  int width_ = 0;
  int height_ = 0;
  bool short_of_usable_pixels_ = false;
  bool takes_grazing_ = false;  // There was hardly anything else when it was filled.
  std::vector<SampleFootprint> footprints_;
};

}  // namespace pleinair
