// Counts shadow volumes in the stencil buffer, from the far end (z-fail), so that the camera may
// stand inside them.
#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec4.hpp>

#include "render/internal/caster_buffers.h"
#include "render/internal/shader_program.h"
#include "render/internal/shadow_caster.h"

namespace pleinair {

// Source  Everitt and Kilgard 2002, "Practical and robust stenciled shadow volumes": two-sided
//         z-fail with a projection without far plane; sides that end at infinity.
//
// Stencil  Bits 0 to 6 count, modulo 128; bit 7 keeps "in shadow" where a caster too deep for that
//          is drawn in several batches. After Finish(), a sample is in shadow where the stencil is
//          not 0.
class VolumeStencil {
 public:
  // Whether caps can lie in front of the surface whose depth is in the buffer. Where all casters
  // are in the depth buffer themselves, no cap can, so that caps count untested: no depth
  // comparison of a caster with itself, no acne, no offset.
  enum class Caps { kTested, kNeverInFront };

  VolumeStencil();

  // Depth of surfaces alone, with the current depth test and masks.
  void DrawSurface(const CasterBuffers& caster, const glm::mat4& clip_from_local) const;

  // The stencil has to be 0 where it will be looked at. Sets its own state; leaves depth and colour
  // unwritten.
  void Begin(const glm::mat4& clip_from_local, const glm::vec4& clip_of_infinity);
  void Draw(const CasterBuffers& caster, const ShadowVolumes& volumes, Caps caps);
  // Opens the masks again.
  void Finish();

 private:
  void Fold();

  ShaderProgram position_program_;
  ShaderProgram screen_program_;
  GlObject no_vertices_;
  glm::mat4 clip_from_local_{1.0f};
  glm::vec4 clip_of_infinity_{0.0f};
  int depth_so_far_ = 0;
};

// The vertex shader of every pass that draws positions: `invariant`, so that depths are equal in
// all.
extern const std::string_view kPositionVertexShader;

}  // namespace pleinair
