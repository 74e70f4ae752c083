// Determines from two pictures of one view whether the exposure has changed, or the light.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "scene/frame.h"
#include "scene/surface_view.h"

namespace pleinair {

// The change between two pictures.
struct ExposureChange {
  enum class Kind {
    kUnknown,   // Nothing to compare with, or nothing that distinguishes the two.
    kNone,      // Neither exposure nor light.
    kExposure,  // Sunlit and shaded surfaces have changed by one factor a channel.
    kLight,     // Otherwise; the exposure may have changed as well.
  };
  Kind kind = Kind::kUnknown;
  glm::dvec3 factor_rgb{1.0};  // For kNone and kExposure: this picture over the last.
};

// A change of exposure or white balance scales everything that the camera sees. A cloud changes the
// sun's part only, or the sky's in the opposite direction. Medians are compared over a grid of
// patches in the sun, in the shade and of the sky itself. The sky, whose clouds drift, is used only
// where one of the others is not in view. While clouds hide the sun, a picture of relative light
// cannot distinguish light from exposure: the change is then reported as one of exposure.
//
// One thread at a time.
class ExposureWatch {
 public:
  // Compares with the picture of the last call. Returns kUnknown where that was of another camera
  // or more than two seconds away.
  ExposureChange Compare(const Frame& frame, const SurfaceView& view);

 private:
  enum class Lit : std::uint8_t { kSun, kShade, kSky, kMixed };
  struct Patch {
    glm::vec3 radiance{0.0f};
    Lit lit = Lit::kMixed;
    bool usable = false;
  };

  std::vector<Patch> patches_;
  std::vector<Patch> last_;
  Camera camera_;
  UtcTime time_{};
  std::array<std::vector<double>, 3> ratios_;  // By channel, of one kind of patch.

  void ReadPatches(const Frame& frame, const SurfaceView& view);
};

}  // namespace pleinair
