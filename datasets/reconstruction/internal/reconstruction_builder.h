// Checks what all readers of reconstructions share.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "calib/reconstruction/reconstruction.h"

namespace pleinair {

// Cameras, pictures and points by the file's own ids, in any order. All functions throw
// std::runtime_error, "WHERE: what was expected".
class ReconstructionBuilder {
 public:
  struct Observed {
    std::int64_t point_id;
    glm::dvec2 pixel;
  };

  void AddCamera(const std::string& where, const std::string& id, const CameraIntrinsics& camera);
  // `camera_from_model` is rigid, or has numbers that are not finite: these are refused.
  void AddPicture(const std::string& where,
                  const std::string& name,
                  const std::string& camera_id,
                  const glm::dmat4& camera_from_model,
                  std::vector<Observed> observed = {});
  // `colour` in [0, 255].
  void AddPoint(const std::string& where,
                std::int64_t id,
                const glm::dvec3& position,
                const glm::dvec3& colour);
  Reconstruction Finish(const std::string& where);

 private:
  Reconstruction made_;
  std::map<std::string, std::uint32_t> camera_of_id_;
  std::unordered_map<std::int64_t, std::uint32_t> point_of_id_;
  std::vector<std::vector<Observed>> observed_;  // A picture each.
};

}  // namespace pleinair
