// A surface in chunks of neighbouring triangles, so that what is out of view costs nothing. No
// OpenGL here.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "scene/camera.h"
#include "scene/mesh.h"

namespace pleinair {

class SurfaceChunks {
 public:
  struct Range {
    std::size_t first = 0;  // Range of Triangles().
    std::size_t count = 0;
    bool operator==(const Range&) const = default;
  };

  SurfaceChunks() = default;
  // Copies both; many triangles are brought in an order by place.
  SurfaceChunks(std::span<const glm::vec3> positions_m, std::span<const glm::uvec3> triangles);

  std::span<const glm::uvec3> Triangles() const { return triangles_; }
  // All triangles that can show in the clip volume, near and far plane apart, and some around it;
  // ranges that follow each other are one.
  std::vector<Range> InView(const glm::mat4& clip_from_position) const;
  // Depth along the optical axis of the nearest point in an undistorted camera's view; infinite
  // where nothing is. As ScreenExtent::nearest_m.
  double NearestInViewM(const CameraIntrinsics& intrinsics,
                        const glm::dmat4& camera_from_position) const;

 private:
  struct Chunk {
    Range range;
    BoundingBox box;
  };

  std::vector<glm::vec3> positions_m_;
  std::vector<glm::uvec3> triangles_;
  std::vector<Chunk> chunks_;
};

}  // namespace pleinair
