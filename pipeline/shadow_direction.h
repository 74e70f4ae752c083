// The sun's direction by the real shadows in pictures: a check of north, pose and time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "scene/frame.h"
#include "scene/mesh.h"

namespace pleinair {

// Set-up of ShadowDirectionFinder.
struct ShadowDirectionOptions {
  double largest_offset_rad =
      0.3491;                  // Candidates reach this far to either side (20 deg); (0, pi].
  double step_rad = 0.004363;  // Between candidates (0.25 deg); (0, largest_offset_rad].
  // At most, per picture; at least 100. With few, corners of shadows are missed, and the rest may
  // support another sun.
  int pixels = 8000;
  int frames = 64;  // At most; of more, an even choice is used. At least 1.

  // Throws std::invalid_argument naming the field and its value.
  void Validate() const;
};

// The agreement of shadows and computed sun. Where not determined, `reason` says why, and the
// numbers are for reports only.
struct ShadowDirection {
  bool determined = false;
  std::string reason;
  // Azimuth of the sun by the real shadows minus the computed one, in the model's frame. It is also
  // the angle on level ground between the shadow of a real upright thing and that of a virtual one,
  // clockwise from virtual to real. For a model whose +Y points to true azimuth A it is -A.
  double azimuth_offset_rad = 0.0;
  // The larger of the two that follow, times the factor by which the frames disagree too much.
  double stddev_rad = 0.0;
  double curvature_stddev_rad = 0.0;  // Width of the posterior over the pictures' parts.
  double spread_stddev_rad = 0.0;     // By leaving out frames, and blocks of the picture.

  // 3 standard deviations and half a degree: the picture contradicts the computed sun.
  bool ContradictsTheSun() const;
};

// The result of one frame.
struct FrameShadowDirection {
  int frame = 0;
  bool sunlit = false;     // Lit and shaded parts of one plane are distinct.
  double contrast = 1.0;   // Lit over shaded radiance, where sunlit.
  std::size_t tiles = 0;   // Parts of the picture that distinguish offsets.
  ShadowDirection shadow;  // By this frame alone.
};

// The result of all frames together, and of each.
struct ShadowDirectionResult {
  ShadowDirection all;                       // One offset for all frames together.
  std::vector<FrameShadowDirection> frames;  // Those that were kept.
};

// The sun by one frame's shadows, searched in all directions.
struct ShownSun {
  // It is significantly 3 deg or more from the stated one: in azimuth, or in any direction.
  bool contradicts = false;
  glm::dvec3 direction_enu{0.0, 0.0, 1.0};  // The stated one where nothing better was found.
  double stddev_rad = 0.0;  // Of the angle to the sun's true direction; 0 where nothing was found.
  ShadowDirection near_stated;  // By small turns about the vertical only.
};

// Collects frames, and finds the one turn of the sun about the vertical under which the shadows
// that the mesh casts explain the pictures best.
//
// Method   Candidates are cast at pixels well inside planes (same group, material and facing). Each
//          plane of each frame has its own lit and shaded level, so that neither albedo nor light
//          nor exposure need be known. A part of the picture (a tile) then has a likelihood of each
//          candidate; see internal/offset_posterior.h for their combination.
// Not      used: that a plane is brighter when it faces the sun. Pictures without sun are no
//          evidence.
// Keeps    1.4 MB for each frame. Not thread-safe.
class ShadowDirectionFinder {
 public:
  // Throws std::invalid_argument for an empty mesh, bad options, or a diffuse region that is
  // neither a group nor a material of the mesh. No regions: all.
  ShadowDirectionFinder(Mesh mesh,
                        std::span<const std::string> diffuse_regions,
                        const ShadowDirectionOptions& options = {});
  ~ShadowDirectionFinder();
  ShadowDirectionFinder(ShadowDirectionFinder&&) noexcept;
  ShadowDirectionFinder& operator=(ShadowDirectionFinder&&) noexcept;

  // `sun_direction_enu`: the computed sun, in the model's frame. A sun below the horizon adds
  // nothing.
  void Add(const Frame& frame, const glm::dvec3& sun_direction_enu);

  // Returns the sun by the shadows in `frame`; the frame is not added. All directions are searched
  // first, for a place, time or orientation with any error. Then turns about the vertical are
  // searched near the stated sun, or near another one that explains far more.
  // Cost  an overcast picture 0.2 s, a sunlit one 0.5 s on two cores: rays.
  ShownSun ShownBy(const Frame& frame, const glm::dvec3& stated_sun_enu);
  // The same; none where it was stopped before it had ended.
  std::optional<ShownSun> ShownBy(const Frame& frame,
                                  const glm::dvec3& stated_sun_enu,
                                  const std::stop_token& stop);

  // The result from all frames added.
  ShadowDirectionResult Result() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pleinair
