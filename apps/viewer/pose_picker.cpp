#include "apps/viewer/pose_picker.h"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>

#include <fmt/format.h>
#include <glm/geometric.hpp>

#include "calib/edge_pose.h"
#include "datasets/new_site.h"
#include "sunmodel/angles.h"

namespace pleinair {
namespace {

constexpr std::size_t kFewestPicks = 4;

}  // namespace

PosePicker::PosePicker(std::shared_ptr<const ViewedSite> site, const Camera& camera)
    : site_(std::move(site)),
      given_(camera),
      shown_(camera),
      edges_(EdgesOf(site_->loaded->site.model.mesh, site_->caster)) {}

void PosePicker::SetSite(std::shared_ptr<const ViewedSite> site) {
  site_ = std::move(site);
  const auto& pose = site_->loaded->sequence.camera_from_world;
  if (!pose || HasUnsavedPicks()) return;
  given_.camera_from_world = *pose;
  shown_ = given_;
}

std::string PosePicker::Describe() const {
  if (!found_) {
    return fmt::format("{} of {} picks: drag corners of the mesh to where the picture shows them",
                       picks_.size(),
                       kFewestPicks);
  }
  if (!*found_) return found_->error().reason;
  const CameraPose& pose = **found_;
  return fmt::format("{:.2f} px rms, {} of {} picks; +/- {:.3f} deg, +/- {:.3f} m",
                     pose.rms_px,
                     std::count(pose.counts.begin(), pose.counts.end(), true),
                     picks_.size(),
                     DegFromRad(pose.rotation_sigma_rad),
                     pose.position_sigma_m);
}

std::optional<glm::dvec2> PosePicker::PixelOf(const glm::dvec3& corner_m) const {
  return ProjectToPixel(shown_, corner_m);
}

// What stands in front by more than the corner's own faces hides it.
bool PosePicker::IsHidden(const glm::dvec3& corner_m) const {
  const glm::dvec3 eye = shown_.CentreWorldM();
  const double distance_m = glm::distance(corner_m, eye);
  constexpr double kShare = 0.995;
  return site_->caster.Occluded(glm::vec3(eye),
                                glm::vec3((corner_m - eye) / distance_m),
                                static_cast<float>(kShare * distance_m));
}

std::optional<glm::dvec3> PosePicker::CornerAt(const glm::dvec2& pixel, double reach_px) const {
  std::optional<glm::dvec3> nearest;
  for (const MeshEdge& edge : edges_) {
    if (!edge.is_sharp) continue;
    for (const glm::dvec3& corner : {edge.from_m, edge.to_m}) {
      const auto at = PixelOf(corner);
      if (!at || glm::distance(*at, pixel) >= reach_px || IsHidden(corner)) continue;
      reach_px = glm::distance(*at, pixel);
      nearest = corner;
    }
  }
  return nearest;
}

std::vector<glm::dvec2> PosePicker::CornersInView() const {
  std::vector<glm::dvec3> corners;
  corners.reserve(2 * edges_.size());
  for (const MeshEdge& edge : edges_) {
    if (edge.is_sharp) corners.insert(corners.end(), {edge.from_m, edge.to_m});
  }
  // An edge's ends are copies of the mesh's vertices: the same corner has the same numbers.
  std::sort(corners.begin(), corners.end(), [](const glm::dvec3& a, const glm::dvec3& b) {
    return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
  });
  corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
  const glm::dvec2 last(shown_.intrinsics.width_px - 1, shown_.intrinsics.height_px - 1);
  std::vector<glm::dvec2> seen;
  for (const glm::dvec3& corner : corners) {
    const auto at = PixelOf(corner);
    if (!at || at->x < 0.0 || at->y < 0.0 || at->x > last.x || at->y > last.y) continue;
    if (!IsHidden(corner)) seen.push_back(*at);
  }
  return seen;
}

void PosePicker::Pick(const glm::dvec3& corner_world_m, const glm::dvec2& pixel) {
  undo_.Remember(picks_);
  const auto known = std::find_if(picks_.begin(), picks_.end(), [&](const PointMatch& pick) {
    return pick.point_world_m == corner_world_m;
  });
  if (known != picks_.end()) {
    known->pixel = pixel;
  } else {
    picks_.push_back({corner_world_m, pixel});
  }
  Solve();
}

void PosePicker::Undo() {
  if (undo_.Undo(picks_)) Solve();
}

void PosePicker::Redo() {
  if (undo_.Redo(picks_)) Solve();
}

void PosePicker::Clear() {
  undo_.Remember(picks_);
  picks_.clear();
  shown_ = given_;
  Solve();
}

void PosePicker::Solve() {
  found_.reset();
  if (picks_.size() < kFewestPicks) return;
  found_ = FindCameraPose(
      Lens(shown_.intrinsics), picks_, PickedPointOptions(), shown_.camera_from_world);
  if (*found_) shown_.camera_from_world = (*found_)->camera_from_world;
}

std::string PosePicker::RefineByEdges(const Rgb8Image& picture) {
  const auto refined = RefinePoseByEdges(
      Lens(shown_.intrinsics), picture, {edges_, site_->caster}, shown_.camera_from_world);
  if (!refined) return refined.error().reason;
  shown_.camera_from_world = refined->camera_from_world;
  return fmt::format(
      "by edges: {:.2f} px rms, {:.0f} % of them found; +/- {:.3f} deg, +/- {:.3f} m",
      refined->rms_px,
      100.0 * refined->found_share,
      DegFromRad(refined->rotation_sigma_rad),
      refined->position_sigma_m);
}

bool PosePicker::HasUnsavedPicks() const { return !picks_.empty() || HasOtherPose(); }

bool PosePicker::HasOtherPose() const {
  return shown_.camera_from_world != given_.camera_from_world;
}

void PosePicker::Save() {
  if (!picks_.empty() && !HasOtherPose()) {
    throw std::runtime_error("pose: no pose yet: " + Describe());
  }
  // A pose without picks is one that a person has judged on the picture.
  const double stddev_rad = found_ && *found_ ? (*found_)->rotation_sigma_rad : 0.0;
  SetSitePose(site_->loaded->sequence.file, shown_.camera_from_world, stddev_rad);
  given_ = shown_;
  picks_.clear();
  undo_ = {};
  found_.reset();
}

}  // namespace pleinair
