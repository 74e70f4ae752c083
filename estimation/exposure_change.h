// Told from two pictures of one view: has the exposure changed, or the light?
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "scene/frame.h"
#include "scene/surface_view.h"

namespace pleinair {

struct ExposureChange {
  enum class Kind {
    kUnknown,   // Nothing to compare with, or nothing that tells the two apart.
    kNone,      // Neither exposure nor light.
    kExposure,  // Sunlit and shaded surfaces have changed by one factor a channel.
    kLight,     // Otherwise; the exposure may have changed beside.
  };
  Kind kind = Kind::kUnknown;
  glm::dvec3 factor_rgb{1.0};  // Of kNone and kExposure: this picture over the last.
};

// A change of exposure or white balance scales all that the camera sees; a cloud changes the sun's
// part alone, or the sky's the other way. Compared are the medians over a grid of patches in the
// sun, in the shade and of the sky itself; the latter, whose clouds drift, only where one of the
// others is not in view. With the sun behind clouds, light and exposure are the same to a picture
// of relative light: it is taken for exposure.
//
// One thread at a time.
class ExposureWatch {
 public:
  // Compares with the last picture that was given. Of another camera or one more than two seconds
  // apart it knows nothing.
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
