#include "apps/viewer/object_editor.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <glm/geometric.hpp>

#include "calib/lens.h"
#include "datasets/site_objects.h"
#include "objects/surface_point.h"

namespace pleinair {
namespace {

constexpr const char* kNoSurface = "no surface of the model is seen there";
constexpr const char* kNoRoom = "the object does not fit there";

// Positions and triangles of all parts, as one.
Mesh Joined(const std::vector<VirtualObject>& parts) {
  Mesh joined;
  for (const VirtualObject& part : parts) {
    const auto first = static_cast<std::uint32_t>(joined.positions_m.size());
    joined.positions_m.insert(
        joined.positions_m.end(), part.mesh.positions_m.begin(), part.mesh.positions_m.end());
    for (const glm::uvec3& triangle : part.mesh.triangles) {
      joined.triangles.push_back(triangle + first);
    }
  }
  return joined;
}

struct Ray {
  glm::dvec3 origin_m;
  glm::dvec3 direction;
};

std::optional<Ray> RayThrough(const Camera& camera, const glm::dvec2& pixel) {
  const std::optional<glm::dvec3> direction = DirectionFromPixel(camera.intrinsics, pixel);
  if (!direction) return std::nullopt;
  return Ray{camera.CentreWorldM(),
             glm::transpose(glm::dmat3(camera.camera_from_world)) * *direction};
}

}  // namespace

void SaveObjectsWithFiles(const std::filesystem::path& file,
                          std::vector<VirtualObjectEntry> objects) {
  for (VirtualObjectEntry& object : objects) {
    if (object.mesh.is_absolute()) object.mesh = BringObjectFile(file.parent_path(), object.mesh);
  }
  SaveObjects(file, objects);
}

ObjectEditor::ObjectEditor(std::shared_ptr<const ViewedSite> site) : site_(std::move(site)) {
  now_.objects = site_->loaded->sequence.virtual_objects;
  if (!now_.objects.empty()) now_.selected = 0;
}

void ObjectEditor::SelectNext(int step) {
  const auto count = static_cast<int>(now_.objects.size());
  if (count == 0) return;
  const int last = now_.selected ? static_cast<int>(*now_.selected) : (step > 0 ? -1 : 0);
  now_.selected = static_cast<std::size_t>((last + step + count) % count);
}

std::optional<std::size_t> ObjectEditor::ObjectAt(const Camera& camera,
                                                  const glm::dvec2& pixel) const {
  const std::optional<Ray> ray = RayThrough(camera, pixel);
  if (!ray) return std::nullopt;
  float nearest_m = std::numeric_limits<float>::infinity();
  const auto wall = site_->caster.Intersect(glm::vec3(ray->origin_m), glm::vec3(ray->direction));
  if (wall) nearest_m = wall->distance_m;
  std::optional<std::size_t> found;
  for (std::size_t i = 0; i < now_.objects.size(); ++i) {
    const glm::dmat4 object_from_world = glm::inverse(now_.objects[i].world_from_object);
    const glm::dvec3 origin(object_from_world * glm::dvec4(ray->origin_m, 1.0));
    const glm::dvec3 along(object_from_world * glm::dvec4(ray->direction, 0.0));
    const double scale = glm::length(along);
    const auto hit =
        ShapeOf(now_.objects[i].mesh).caster.Intersect(glm::vec3(origin), glm::vec3(along / scale));
    if (!hit || !(hit->distance_m / scale < nearest_m)) continue;
    nearest_m = static_cast<float>(hit->distance_m / scale);
    found = i;
  }
  return found;
}

void ObjectEditor::BeginDrag() {
  is_dragging_ = true;
  drag_is_remembered_ = false;
}

void ObjectEditor::EndDrag() { is_dragging_ = false; }

tl::expected<glm::dmat4, std::string> ObjectEditor::RestingAt(const VirtualObjectEntry& object,
                                                              const Camera& camera,
                                                              const glm::dvec2& pixel) const {
  const Mesh& mesh = site_->loaded->site.model.mesh;
  const auto point = SurfaceAt(site_->caster, mesh, camera, pixel);
  if (!point) return tl::unexpected(kNoSurface);
  const auto resting =
      RestOn(ShapeOf(object.mesh).placeable, object.world_from_object, *point, site_->caster, mesh);
  if (!resting) return tl::unexpected(kNoRoom);
  return resting->world_from_object;
}

std::string ObjectEditor::RestAt(const Camera& camera, const glm::dvec2& pixel) {
  if (!now_.selected) return {};
  const auto pose = RestingAt(now_.objects[*now_.selected], camera, pixel);
  if (!pose) return pose.error();
  Remember();
  SelectedPose() = *pose;
  return {};
}

std::string ObjectEditor::Nudge(const Camera& camera, const glm::dvec2& step_px) {
  if (!now_.selected) return {};
  const VirtualObjectEntry& object = now_.objects[*now_.selected];
  const glm::dvec3 foot = FootOf(ShapeOf(object.mesh).placeable, object.world_from_object);
  const glm::dvec3 foot_camera(camera.camera_from_world * glm::dvec4(foot, 1.0));
  const auto seen_at = ProjectToPixel(camera.intrinsics, foot_camera);
  if (!seen_at) return "the object is not in view";
  return RestAt(camera, *seen_at + step_px);
}

void ObjectEditor::Turn(double angle_rad) {
  if (!now_.selected) return;
  Remember();
  SelectedPose() =
      Turned(ShapeOf(now_.objects[*now_.selected].mesh).placeable, SelectedPose(), angle_rad);
}

void ObjectEditor::Lift(double height_m) {
  if (!now_.selected) return;
  Remember();
  SelectedPose() = Lifted(SelectedPose(), height_m);
}

void ObjectEditor::Scale(double factor) {
  if (!now_.selected) return;
  Remember();
  SelectedPose() =
      Scaled(ShapeOf(now_.objects[*now_.selected].mesh).placeable, SelectedPose(), factor);
}

void ObjectEditor::Duplicate() {
  if (!now_.selected) return;
  Remember();
  VirtualObjectEntry copy = now_.objects[*now_.selected];
  // Beside the first one, not in it.
  const BoundingBox& box = ShapeOf(copy.mesh).box;
  copy.world_from_object = glm::dmat4(copy.world_from_object) *
                           glm::dmat4(1.0,
                                      0.0,
                                      0.0,
                                      0.0,
                                      0.0,
                                      1.0,
                                      0.0,
                                      0.0,
                                      0.0,
                                      0.0,
                                      1.0,
                                      0.0,
                                      1.1 * static_cast<double>(box.upper_m.x - box.lower_m.x),
                                      0.0,
                                      0.0,
                                      1.0);
  now_.objects.push_back(std::move(copy));
  now_.selected = now_.objects.size() - 1;
}

void ObjectEditor::Delete() {
  if (!now_.selected) return;
  Remember();
  now_.objects.erase(now_.objects.begin() + static_cast<std::ptrdiff_t>(*now_.selected));
  if (now_.objects.empty()) {
    now_.selected.reset();
  } else {
    now_.selected = std::min(*now_.selected, now_.objects.size() - 1);
  }
}

std::string ObjectEditor::Add(const std::filesystem::path& mesh,
                              const Camera& camera,
                              const glm::dvec2& pixel) {
  VirtualObjectEntry added{std::filesystem::absolute(mesh), glm::dmat4(1.0)};
  const auto pose = RestingAt(added, camera, pixel);
  if (!pose) return pose.error();
  added.world_from_object = *pose;
  Remember();
  now_.objects.push_back(std::move(added));
  now_.selected = now_.objects.size() - 1;
  return {};
}

void ObjectEditor::Undo() {
  if (undone_to_.empty()) return;
  redone_to_.push_back(std::exchange(now_, std::move(undone_to_.back())));
  undone_to_.pop_back();
  ++edits_;
}

void ObjectEditor::Redo() {
  if (redone_to_.empty()) return;
  undone_to_.push_back(std::exchange(now_, std::move(redone_to_.back())));
  redone_to_.pop_back();
  ++edits_;
}

void ObjectEditor::Save() {
  SaveObjectsWithFiles(site_->loaded->sequence.file, now_.objects);
  saved_id_ = now_.id;
}

std::array<glm::dvec3, 8> ObjectEditor::BoxOf(std::size_t object) const {
  const VirtualObjectEntry& entry = now_.objects[object];
  std::array<glm::dvec3, 8> corners;
  const auto local = CornersOf(ShapeOf(entry.mesh).box);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    corners[i] = glm::dvec3(entry.world_from_object * glm::dvec4(glm::dvec3(local[i]), 1.0));
  }
  return corners;
}

const ObjectEditor::Shape& ObjectEditor::ShapeOf(const std::filesystem::path& mesh) const {
  const auto known = shapes_.find(mesh);
  if (known != shapes_.end()) return known->second;
  const Mesh joined =
      Joined(LoadObject(site_->loaded->sequence.folder, {mesh, glm::dmat4(1.0)}, 0).parts);
  return shapes_
      .emplace(mesh, Shape{PlaceableObject(joined), RayCaster(joined), BoundingBoxOf(joined)})
      .first->second;
}

void ObjectEditor::Remember() {
  if (!(is_dragging_ && drag_is_remembered_)) {
    undone_to_.push_back(now_);
    redone_to_.clear();
  }
  drag_is_remembered_ = true;
  now_.id = ++edits_;
}

}  // namespace pleinair
