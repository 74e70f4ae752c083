#include "datasets/reconstruction/internal/reconstruction_builder.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "calib/lens.h"
#include "datasets/internal/sequence_values.h"

namespace pleinair {
namespace {

// Beyond, the squares of differences lose what a plane's fit needs.
constexpr double kFarthest = 1e9;

bool IsSane(const glm::dvec3& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}) <= kFarthest &&
         !std::isnan(v.x + v.y + v.z);
}

[[noreturn]] void Refuse(const std::string& where, const std::string& what) {
  throw std::runtime_error(where + ": " + what);
}

}  // namespace

void ReconstructionBuilder::AddCamera(const std::string& where,
                                      const std::string& id,
                                      const CameraIntrinsics& camera) {
  if (std::max(camera.width_px, camera.height_px) > kMaxImageSidePx) {
    Refuse(where, "expected a camera of at most 65536 pixels a side");
  }
  try {
    const Lens valid(camera);
  } catch (const std::invalid_argument& error) {
    Refuse(where, error.what());
  }
  const auto index = static_cast<std::uint32_t>(made_.cameras.size());
  if (!camera_of_id_.emplace(id, index).second) Refuse(where, "camera " + id + " is there twice");
  made_.cameras.push_back({id, camera});
}

void ReconstructionBuilder::AddPicture(const std::string& where,
                                       const std::string& name,
                                       const std::string& camera_id,
                                       const glm::dmat4& camera_from_model,
                                       std::vector<Observed> observed) {
  const auto camera = camera_of_id_.find(camera_id);
  if (camera == camera_of_id_.end()) {
    Refuse(where, "expected a camera that is there, found camera " + camera_id);
  }
  const bool is_rotation = std::abs(glm::determinant(glm::dmat3(camera_from_model)) - 1.0) < 1e-6;
  if (!is_rotation || !IsSane(glm::dvec3(camera_from_model[3]))) {
    Refuse(where, "expected a rotation and a translation of finite numbers below 1e9");
  }
  if (name.empty()) Refuse(where, "expected the picture's name");
  for (const Observed& seen : observed) {
    if (!(std::abs(seen.pixel.x) <= kFarthest && std::abs(seen.pixel.y) <= kFarthest)) {
      Refuse(where, "expected pixels of finite numbers below 1e9");
    }
  }
  made_.pictures.push_back({name, camera->second, camera_from_model, {}});
  observed_.push_back(std::move(observed));
}

void ReconstructionBuilder::AddPoint(const std::string& where,
                                     std::int64_t id,
                                     const glm::dvec3& position,
                                     const glm::dvec3& colour) {
  if (!IsSane(position)) Refuse(where, "expected coordinates of finite numbers below 1e9");
  const glm::dvec3 clamped = glm::clamp(colour / 255.0, glm::dvec3(0.0), glm::dvec3(1.0));
  if (!(glm::dot(clamped, clamped) <= 3.0)) Refuse(where, "expected a colour of finite numbers");
  const auto index = static_cast<std::uint32_t>(made_.points.size());
  if (!point_of_id_.emplace(id, index).second) {
    Refuse(where, "point " + std::to_string(id) + " is there twice");
  }
  made_.points.push_back({id, position, clamped});
}

Reconstruction ReconstructionBuilder::Finish(const std::string& where) {
  if (made_.pictures.empty()) Refuse(where, "expected a picture with a pose, found none");
  if (made_.points.empty()) Refuse(where, "expected points, found none");
  // Writers use different orders; results must not depend on them.
  std::sort(made_.points.begin(), made_.points.end(), [](const auto& a, const auto& b) {
    return a.id < b.id;
  });
  for (std::uint32_t i = 0; i < made_.points.size(); ++i) point_of_id_[made_.points[i].id] = i;
  std::size_t lost = 0;
  for (std::size_t i = 0; i < observed_.size(); ++i) {
    for (const Observed& seen : observed_[i]) {
      const auto point = point_of_id_.find(seen.point_id);
      if (point == point_of_id_.end()) {
        ++lost;
        continue;
      }
      made_.pictures[i].observations.push_back({point->second, seen.pixel});
    }
  }
  std::sort(made_.pictures.begin(), made_.pictures.end(), [](const auto& a, const auto& b) {
    return a.name < b.name;
  });
  if (lost > 0) {
    made_.notes.push_back(std::to_string(lost) + " observations name points that are not there");
  }
  return std::move(made_);
}

}  // namespace pleinair
