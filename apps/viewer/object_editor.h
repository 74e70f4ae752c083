// The objects of a site as a person moves them, with undo and redo.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <tl/expected.hpp>

#include "apps/viewer/frame_worker.h"
#include "objects/object_placement.h"
#include "scene/ray_caster.h"

namespace pleinair {

class ObjectEditor {
 public:
  explicit ObjectEditor(std::shared_ptr<const ViewedSite> site);

  // The same site, read again.
  void SetSite(std::shared_ptr<const ViewedSite> site) { site_ = std::move(site); }

  const std::vector<VirtualObjectEntry>& Objects() const { return now_.objects; }
  std::optional<std::size_t> Selected() const { return now_.selected; }
  // Changes with every edit.
  std::int64_t Edits() const { return edits_; }
  bool HasUnsavedEdits() const { return now_.id != saved_id_; }
  bool CanUndo() const { return !undone_to_.empty(); }
  bool CanRedo() const { return !redone_to_.empty(); }

  void Select(std::optional<std::size_t> object) { now_.selected = object; }
  // The next one in the list, or the last.
  void SelectNext(int step);
  // The nearest object that the pixel shows, past no real surface.
  std::optional<std::size_t> ObjectAt(const Camera& camera, const glm::dvec2& pixel) const;

  // Edits of the selected object; without one nothing happens. They return what kept them from it,
  // in a line; empty: done. From BeginDrag to EndDrag all edits are one to undo.
  void BeginDrag();
  void EndDrag();
  std::string RestAt(const Camera& camera, const glm::dvec2& pixel);
  // Along its surface, by so much in the picture from where its foot is seen.
  std::string Nudge(const Camera& camera, const glm::dvec2& step_px);
  void Turn(double angle_rad);
  void Lift(double height_m);
  void Scale(double factor);
  void Duplicate();
  void Delete();
  // A mesh file, at rest on what the pixel shows; it is selected. Throws as LoadObject.
  std::string Add(const std::filesystem::path& mesh, const Camera& camera, const glm::dvec2& pixel);

  void Undo();
  void Redo();
  // Into the site's file. Throws std::runtime_error, one line, where it cannot be written.
  void Save();

  // In the world: eight corners of its box, as CornersOf has them; for drawing it.
  std::array<glm::dvec3, 8> BoxOf(std::size_t object) const;

 private:
  struct State {
    std::vector<VirtualObjectEntry> objects;
    std::optional<std::size_t> selected;
    std::int64_t id = 0;  // No two states that differ share one.
  };
  // What is needed of a mesh file, in the object's coordinates.
  struct Shape {
    PlaceableObject placeable;
    RayCaster caster;
    BoundingBox box;
  };

  const Shape& ShapeOf(const std::filesystem::path& mesh) const;
  // The pose of `object` at rest on what the pixel shows, or what keeps it from there, in a line.
  tl::expected<glm::dmat4, std::string> RestingAt(const VirtualObjectEntry& object,
                                                  const Camera& camera,
                                                  const glm::dvec2& pixel) const;
  // The state before an edit can be gone back to.
  void Remember();
  glm::dmat4& SelectedPose() { return now_.objects[*now_.selected].world_from_object; }

  std::shared_ptr<const ViewedSite> site_;
  State now_;
  std::int64_t saved_id_ = 0;
  std::vector<State> undone_to_;
  std::vector<State> redone_to_;
  bool is_dragging_ = false;
  bool drag_is_remembered_ = false;
  std::int64_t edits_ = 0;
  mutable std::map<std::filesystem::path, Shape> shapes_;
};

// Into the site's `file`; meshes from outside are copied into its folder. Throws as SaveObjects and
// BringObjectFile.
void SaveObjectsWithFiles(const std::filesystem::path& file,
                          std::vector<VirtualObjectEntry> objects);

}  // namespace pleinair
