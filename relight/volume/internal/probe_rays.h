// What the rays of a probe meet, as entries of the operator's three sources of light.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "relight/survey/survey.h"
#include "relight/transport/patch_scene.h"

namespace pleinair::internal {

// The survey map's pixel that shows the surface point `position_m` on the side of `normal` (unit),
// with an albedo of its own; nothing where the map sees something else in that direction.
std::optional<std::uint32_t> SurveyPixelOfSurface(const Survey& survey,
                                                  const glm::vec3& position_m,
                                                  const glm::vec3& normal);

// The survey map's pixel in `direction`, where the map shows sky there.
std::optional<std::uint32_t> SurveyPixelOfSky(const Survey& survey, const glm::vec3& direction);

// Map pixels, then faces, then directions of the open sky, laid end to end.
struct SourceLayout {
  // The ray meets nothing and looks below the horizon: no light.
  static constexpr std::uint32_t kDark = 0xffffffffu;
  std::uint32_t pixels = 0;
  std::uint32_t faces = 0;
  std::uint32_t skies = 0;
};

// How many rays met what.
struct RayCounts {
  int sky = 0;
  int front = 0;  // Surfaces, on the side that the winding's normal points to.
  int back = 0;
  int Hits() const { return front + back; }
};

// Casts a fixed set of directions from any point. Keeps references to all it is made from.
class ProbeRays {
 public:
  ProbeRays(const PatchScene& scene,
            const Survey* survey,
            const std::vector<glm::vec3>& directions,
            const SourceLayout& layout)
      : scene_(scene), survey_(survey), directions_(directions), layout_(layout) {}

  // Writes the source that each direction sees from `origin_m`. Safe from any thread.
  // Shape  sources: one entry a direction.
  RayCounts Cast(const glm::vec3& origin_m, std::span<std::uint32_t> sources) const;

 private:
  const PatchScene& scene_;
  const Survey* survey_;
  const std::vector<glm::vec3>& directions_;
  SourceLayout layout_;
};

}  // namespace pleinair::internal
