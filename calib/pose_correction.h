// A fixed camera's stated pose, corrected where its pictures show the mesh's edges elsewhere.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "calib/lens.h"
#include "calib/mesh_edges.h"
#include "scene/image.h"
#include "scene/ray_caster.h"

namespace pleinair {

// The prior of the pose, and what makes a correction.
struct PoseCorrectionOptions {
  // Standard deviations of the stated pose, about and along each axis; above 0. The defaults are
  // for poses whose deviation nobody stated.
  double rotation_sigma_rad = 0.0044;  // 0.25 deg.
  double position_sigma_m = 0.04;
  // Smaller shifts of the picture are not worth a correction; 0 or more.
  double least_shift_px = 0.25;
  // Search distance for edges from where a pose puts them; above 1. None: a sixtieth of the
  // picture's width, twice what the deviations above move edges by in most pictures.
  std::optional<double> reach_px;

  // Throws std::invalid_argument naming the field and its value.
  void Validate() const;
};

struct PoseCorrection {
  // Whether the pose is another than the stated one. Where not, `reason` says why.
  bool corrected = false;
  std::string reason;
  glm::dmat4 camera_from_world{1.0};
  // Covariance of what remains unknown of this pose: a rotation about the camera's axes, then a
  // translation along them, rad and m.
  std::array<std::array<double, 6>, 6> motion_covariance{};
  double shift_px = 0.0;  // Median shift of the mesh's visible edges in the picture.
  // What remains unknown of the edges' places, root mean square. Other places may be known less
  // well: PlaceSigmaPx.
  double shift_sigma_px = 0.0;
  // How far the mesh's corners are off along each axis, standard deviation: the likeliest.
  double mesh_sigma_m = 0.0;
  double found_share = 0.0;   // Share of the mesh's edges that the pictures show.
  double chance_share = 0.0;  // Expected of the pictures' other edges, by chance.
  // Natural logarithm of the odds that the stated pose is off, by the deviations that are expected,
  // against its being exact.
  double log_odds = 0.0;
};

// The mean pose, given the stated one and the edges in all of the pictures. Shadows and things that
// the mesh lacks have edges, too. So the stated pose counts as a measurement with its deviations,
// and the influence of each place is limited. A search from several turned starts takes each edge
// to be off by itself. Its end is adjusted together with the mesh: corners are displaced, with the
// edges that meet there, and edges that do not agree with the others count less. How far the mesh
// is off follows from the pictures, too: with a mesh that is far off, edges that are elsewhere say
// little of the pose. The stated pose is kept where it is more likely exact than off.
//
// `pictures`  of one camera at one pose, at least one; best from different times of the day.
// Source      As RefinePoseByEdges, with a normal prior on the pose and on the mesh's corners.
// Cost        some 0.05 s of one thread for each picture of 640 x 480, and 0.3 s.
// Throws      std::invalid_argument: no picture, one of another size than the lens's; as Validate.
PoseCorrection CorrectPoseByEdges(const Lens& lens,
                                  std::span<const Rgb8Image> pictures,
                                  const EdgeModel& model,
                                  const glm::dmat4& stated_camera_from_world,
                                  const PoseCorrectionOptions& options = {});

// Returns what remains unknown of a point's place in the picture, such as an object's on the ground
// between the edges: the root of the sum of both coordinates' variances. None where the point is
// not in the picture. Only the pose's deviation counts, not that of the point itself.
std::optional<double> PlaceSigmaPx(const Lens& lens,
                                   const PoseCorrection& found,
                                   const glm::dvec3& point_world_m);

}  // namespace pleinair
