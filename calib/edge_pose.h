// Where a camera stands, from the mesh's edges in its picture and a rough pose.
#pragma once

#include <span>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <tl/expected.hpp>

#include "calib/camera_pose.h"
#include "calib/lens.h"
#include "calib/mesh_edges.h"
#include "scene/image.h"
#include "scene/ray_caster.h"

namespace pleinair {

struct EdgePoseOptions {
  // How far from where the rough pose puts them the edges are looked for, in pixels; above 1.
  double reach_px = 20.0;
  // How well the mesh's edges are expected to be where the real ones are; 0 or more. For the
  // deviations alone.
  double mesh_sigma_m = 0.01;
  // A pose whose rotation or position is known less well is no pose; above 0.
  double largest_rotation_sigma_rad = 0.02;
  double largest_position_sigma_m = 1.0;

  // Throws std::invalid_argument naming the field and its value.
  void Validate() const;
};

// A place on an edge of the mesh that the camera sees.
struct EdgeSample {
  glm::dvec2 pixel{0.0};   // Where the pose puts it.
  glm::dvec2 normal{0.0};  // Unit, across the edge.
  double offset_px = 0.0;  // Of the picture's nearest edge along the normal; infinite: none.
  bool counts = false;     // It is near enough to be that edge.
};

struct EdgePose {
  glm::dmat4 camera_from_world{1.0};
  double rms_px = 0.0;        // Over the samples that count, across their edges.
  double found_share = 0.0;   // Of the samples, that count.
  double chance_share = 0.0;  // That would for the picture's other edges alone.
  // Edges count, not samples, as one that is misplaced is so all along. By how much they are is
  // mesh_sigma_m, corrected by how far entire edges lie from the picture's.
  double rotation_sigma_rad = 0.0;  // About the worst axis.
  double position_sigma_m = 0.0;    // Of the camera's centre, all three axes together.
  // About and along each of the camera's axes.
  glm::dvec3 axis_rotation_sigma_rad{0.0};
  glm::dvec3 axis_position_sigma_m{0.0};
  std::vector<EdgeSample> samples;
};

// The pose near `rough_camera_from_world` whose projected edges (creases, outlines, ends, borders
// of materials; hidden parts left out) lie on edges of the picture, least squares across the edges
// with the weights of outliers falling off. Each sample of an edge proposes the steps of light
// along its normal; the nearest one counts. Many turned starts are tried, and the pose is kept on
// whose edges the picture has most. Or why there is none: few edges in view, not more of them found
// than by chance, two poses that are nearly as good, a pose that they leave open or that is not
// near.
//
// Source   Drummond and Cipolla, IEEE PAMI 24(7), 2002 (searching along normals); several
// hypotheses
//          a sample by Wuest, Vial and Stricker, ISMAR 2005. Deviations follow from edges that are
//          off independently of each other, all along; parallel ones next to each other are one.
// Cost     1 s of one thread for a picture of 640 x 480.
// Throws   std::invalid_argument: a picture that has not the lens's size, and as Validate.
tl::expected<EdgePose, UndeterminedPose> RefinePoseByEdges(
    const Lens& lens,
    const Rgb8Image& picture,
    std::span<const MeshEdge> edges,
    const RayCaster& rays,
    const glm::dmat4& rough_camera_from_world,
    const EdgePoseOptions& options = {});

}  // namespace pleinair
