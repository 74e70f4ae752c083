// The camera's pose from corners of the mesh that a person drags to where the picture shows them.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "apps/viewer/frame_worker.h"
#include "apps/viewer/undo_stack.h"
#include "calib/camera_pose.h"
#include "calib/mesh_edges.h"

namespace pleinair {

class PosePicker {
 public:
  // `camera`: of the frames that are shown.
  PosePicker(std::shared_ptr<const ViewedSite> site, const Camera& camera);

  // The same site, read again: where nothing is picked, with the pose that it has now.
  void SetSite(std::shared_ptr<const ViewedSite> site);

  // The pose that is shown: the picks', where they determine one, or else the site's.
  const Camera& Shown() const { return shown_; }
  const std::vector<MeshEdge>& Edges() const { return edges_; }
  const std::vector<PointMatch>& Picks() const { return picks_; }
  // The pose by the picks; none with fewer than four. Its residuals are in the order of the picks.
  const std::optional<tl::expected<CameraPose, UndeterminedPose>>& Found() const { return found_; }
  // What there is to say of the pose, in a line.
  std::string Describe() const;

  // The corner of a sharp edge that is shown next to the pixel, hidden ones left out.
  std::optional<glm::dvec3> CornerAt(const glm::dvec2& pixel, double reach_px) const;
  // Where all such corners are seen, each once.
  std::vector<glm::dvec2> CornersInView() const;
  // A pick of that corner, in place of an earlier one.
  void Pick(const glm::dvec3& corner_world_m, const glm::dvec2& pixel);
  void Undo();
  void Redo();
  void Clear();
  // The shown pose, refined by the mesh's edges in the picture. Returns why not; empty: done.
  std::string RefineByEdges(const Rgb8Image& picture);

  // Whether there are picks, or a pose other than the last saved one.
  bool HasUnsavedPicks() const;
  // Into the site's file. The picks are then done with: the next ones are of this pose. Throws
  // std::runtime_error, one line; where the picks give no pose.
  void Save();

 private:
  void Solve();
  bool HasOtherPose() const;  // Than the given one.
  // Where the corner is seen; none: behind the camera, or hidden.
  std::optional<glm::dvec2> PixelOf(const glm::dvec3& corner_m) const;
  bool IsHidden(const glm::dvec3& corner_m) const;

  std::shared_ptr<const ViewedSite> site_;
  Camera given_;  // With the site's pose, or the last that was saved.
  Camera shown_;
  std::vector<MeshEdge> edges_;
  std::vector<PointMatch> picks_;
  UndoStack<std::vector<PointMatch>> undo_;
  std::optional<tl::expected<CameraPose, UndeterminedPose>> found_;
};

}  // namespace pleinair
