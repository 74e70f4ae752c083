// The pose of a camera, from the mesh's edges in its picture and a rough pose.
#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <tl/expected.hpp>

#include "calib/camera_pose.h"
#include "calib/lens.h"
#include "calib/mesh_edges.h"
#include "scene/image.h"
#include "scene/ray_caster.h"

namespace pleinair {

// Limits and noise of the search.
struct EdgePoseOptions {
  // Search distance for edges from where the rough pose puts them, in pixels; above 1.
  double reach_px = 20.0;
  // Standard deviation of the mesh's edges from the real ones; 0 or more. Used only for the
  // deviations.
  double mesh_sigma_m = 0.01;
  // A pose whose rotation or position is known less well is no pose; above 0.
  double largest_rotation_sigma_rad = 0.02;
  double largest_position_sigma_m = 1.0;

  // Throws std::invalid_argument naming the field and its value.
  void Validate() const;
};

// A pose and its accuracy.
struct EdgePose {
  glm::dmat4 camera_from_world{1.0};
  double rms_px = 0.0;        // Over the samples that count, across their edges.
  double found_share = 0.0;   // Share of the samples that are inliers.
  double chance_share = 0.0;  // Share expected from the picture's other edges by chance.
  // Edges count, not samples, since a misplaced edge is misplaced along all of its length. Edges
  // are misplaced by mesh_sigma_m, corrected by how far entire edges lie from the picture's.
  double rotation_sigma_rad = 0.0;  // About the worst axis.
  double position_sigma_m = 0.0;    // For the camera's centre, all three axes together.
  // About and along each of the camera's axes.
  glm::dvec3 axis_rotation_sigma_rad{0.0};
  glm::dvec3 axis_position_sigma_m{0.0};
};

// Returns the pose near `rough_camera_from_world` whose projected edges lie on edges of the
// picture, by robust least squares across the edges. Edges are creases, outlines, ends and borders
// of materials, without hidden parts. Each sample of an edge proposes the steps of light along its
// normal; the nearest one counts. Many turned starts are tried, and the pose with most of its edges
// in the picture is kept. Or the reason why there is none: few edges in view, no more of them found
// than by chance, or a pose that is ambiguous, undetermined or not near.
//
// Source   Drummond and Cipolla, IEEE PAMI 24(7), 2002 (searching along normals); several
//          hypotheses for each sample by Wuest, Vial and Stricker, ISMAR 2005. Deviations assume
//          that edges are off independently of each other, each along all of its length; parallel
//          ones next to each other count as one.
// Cost     1 s of one thread for a picture of 640 x 480.
// Throws   std::invalid_argument: a picture of another size than the lens's, and as Validate.
tl::expected<EdgePose, UndeterminedPose> RefinePoseByEdges(
    const Lens& lens,
    const Rgb8Image& picture,
    const EdgeModel& model,
    const glm::dmat4& rough_camera_from_world,
    const EdgePoseOptions& options = {});

}  // namespace pleinair
