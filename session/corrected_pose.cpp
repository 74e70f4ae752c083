#include "session/corrected_pose.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <glm/geometric.hpp>

#include "calib/camera_pose.h"
#include "calib/mesh_edges.h"
#include "calib/pose_correction.h"
#include "calib/shown_picture.h"
#include "datasets/frame_source.h"
#include "scene/camera.h"
#include "scene/ray_caster.h"
#include "sunmodel/angles.h"

namespace pleinair {
namespace {

constexpr int kFramesLookedAt = 5;
// Edges of finer meshes, from photogrammetry, are mostly noise, and take long to find.
constexpr std::size_t kMostTriangles = 100'000;

// None where the camera moves.
std::optional<glm::dmat4> FixedPose(const Sequence& sequence) {
  std::optional<glm::dmat4> pose;
  for (std::size_t i = 0; i < sequence.frames.size(); ++i) {
    const glm::dmat4 here = sequence.CameraOfFrame(i).camera_from_world;
    if (pose && *pose != here) return std::nullopt;
    pose = here;
  }
  return pose;
}

// Middles of equal parts of the recording; frames that cannot be read are left out. Of a video only
// the first: what lies before a picture is decoded for it.
std::vector<Rgb8Image> PicturesOf(const Sequence& sequence, FrameSource& frames) {
  std::vector<Rgb8Image> pictures;
  const bool is_video = sequence.frames.front().video_frame.has_value();
  const int count = is_video ? 1 : static_cast<int>(sequence.frames.size());
  const int parts = std::min(count, kFramesLookedAt);
  for (int part = 0; part < parts; ++part) {
    if (!frames.Seek((2 * part + 1) * count / (2 * parts))) break;
    auto frame = frames.Next();
    if (!frame || !*frame) continue;
    pictures.push_back((*frame)->codes ? *std::move((*frame)->codes)
                                       : Shown(std::move((*frame)->radiance)));
  }
  return pictures;
}

// What remains unknown of the objects' places in the picture; empty where none is in view.
std::string ObjectsSigmaText(const Sequence& sequence, const PoseCorrection& found) {
  const Lens lens(sequence.intrinsics);
  double largest_px = 0.0;
  for (const VirtualObjectEntry& object : sequence.virtual_objects) {
    const glm::dvec3 foot_m(object.world_from_object[3]);
    largest_px = std::max(largest_px, PlaceSigmaPx(lens, found, foot_m).value_or(0.0));
  }
  if (!(largest_px > 0.0)) return {};
  return fmt::format("; objects' places in the picture are known to {:.1f} px", largest_px);
}

}  // namespace

std::string CorrectPose(const SessionOptions& options, const Mesh& mesh, Sequence& sequence) {
  if (!options.correct_pose || !sequence.HasPictures() || mesh.triangles.size() > kMostTriangles) {
    return {};
  }
  const std::optional<glm::dmat4> stated = FixedPose(sequence);
  if (!stated) return {};
  PoseCorrectionOptions known;
  if (sequence.pose_stddev_rad) {
    if (*sequence.pose_stddev_rad == 0.0) return {};
    known.position_sigma_m *= *sequence.pose_stddev_rad / known.rotation_sigma_rad;
    known.rotation_sigma_rad = *sequence.pose_stddev_rad;
  }
  const auto frames = MakeRecordedFrameSource(sequence, options.frames, options.camera_noise);
  const std::vector<Rgb8Image> pictures = PicturesOf(sequence, *frames);
  if (pictures.empty()) return {};
  const RayCaster rays(mesh);
  const PoseCorrection found = CorrectPoseByEdges(
      Lens(sequence.intrinsics), pictures, {EdgesOf(mesh, rays), rays}, *stated, known);
  if (!found.corrected) return {};
  sequence.camera_from_world = found.camera_from_world;
  for (FrameEntry& frame : sequence.frames) frame.camera_from_world.reset();
  return fmt::format(
      "camera_from_world: the mesh's edges are {:.1f} px from where it puts them in {} frame(s); "
      "the camera is turned by {:.2f} deg and moved by {:.3f} m{} (correct_pose=off keeps the "
      "stated pose)",
      found.shift_px,
      pictures.size(),
      DegFromRad(RotationBetweenRad(*stated, found.camera_from_world)),
      glm::distance(Camera{{}, *stated}.CentreWorldM(),
                    Camera{{}, found.camera_from_world}.CentreWorldM()),
      ObjectsSigmaText(sequence, found));
}

}  // namespace pleinair
