// Checks whether the mesh's edges agree with edges in photographs.
#pragma once

#include <vector>

#include <glm/vec2.hpp>

#include "scene/camera.h"
#include "scene/image.h"
#include "scene/mesh.h"
#include "scene/ray_caster.h"

namespace pleinair {

// The agreement of the mesh's edges with pictures.
struct EdgeFit {
  // Shift from the mesh's edges to those in the pictures, as a share of the picture's width.
  glm::dvec2 shift{0.0};
  // Contrast of the pictures over the mesh's edges relative to all shifts, in standard deviations:
  // with that shift, and without.
  double sharpness = 0.0;
  double sharpness_as_stated = 0.0;
  // Whether both halves of the mesh's edges give that shift.
  bool is_agreed = false;

  // A larger shift than pose and mesh of a usable site have: 1.8 % of the width, 1 to 2 deg.
  bool IsShifted() const;
  // No shift within reach gives agreement.
  bool IsLost() const;
};

// Method  The contrast of log radiance over each edge between surfaces (Segments), with all edges
//         shifted together by up to 6 % of the picture's width. It is largest where mesh and
//         picture agree. Edges of shadows are in other places, and differ from frame to frame.
class EdgeChecker {
 public:
  // Keeps references.
  EdgeChecker(const Mesh& mesh, const RayCaster& caster) : mesh_(mesh), caster_(caster) {}

  void Add(const RgbImage& radiance, const Camera& camera);
  // The result of all pictures added; zero where none shows an edge of the mesh.
  EdgeFit Result() const;

 private:
  const Mesh& mesh_;
  const RayCaster& caster_;
  std::vector<double> contrast_[2];  // Contrast by shift, for each half of the edges.
};

}  // namespace pleinair
