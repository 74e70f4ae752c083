// Whether the mesh's edges are where photographs have edges.
#pragma once

#include <vector>

#include <glm/vec2.hpp>

#include "scene/camera.h"
#include "scene/image.h"
#include "scene/mesh.h"
#include "scene/ray_caster.h"

namespace pleinair {

struct EdgeFit {
  // From where the mesh's edges are seen to where the pictures have them, as a share of the
  // picture's width.
  glm::dvec2 shift{0.0};
  // How far the pictures' contrast over the mesh's edges stands out among all shifts, in standard
  // deviations: with that shift, and as the edges are.
  double sharpness = 0.0;
  double sharpness_as_stated = 0.0;
  // Both halves of the mesh's edges ask for that shift.
  bool is_agreed = false;

  // Further off than pose and mesh of a usable site: 1.8 % of the width, 1 to 2 deg.
  bool IsShifted() const;
  // No shift within reach brings the edges to where the pictures have any.
  bool IsLost() const;
};

// Method  The contrast of log radiance over each edge between surfaces (Segments), with all edges
//         shifted together by up to 6 % of the picture's width; it is largest where mesh and
//         picture agree. Shadows' edges are in other places, and differ from frame to frame.
class EdgeChecker {
 public:
  // Keeps references.
  EdgeChecker(const Mesh& mesh, const RayCaster& caster) : mesh_(mesh), caster_(caster) {}

  void Add(const RgbImage& radiance, const Camera& camera);
  // Of all pictures added; zero where none shows an edge of the mesh.
  EdgeFit Result() const;

 private:
  const Mesh& mesh_;
  const RayCaster& caster_;
  std::vector<double> contrast_[2];  // By shift, of each half of the edges.
};

}  // namespace pleinair
