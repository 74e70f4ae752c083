// A caster on the device: its surface, for depth, and its shadow volumes.
#pragma once

#include "render/internal/gl_object.h"
#include "render/internal/shadow_caster.h"
#include "render/internal/surface_chunks.h"

namespace pleinair {

// Vertex attribute 0 is (position, 1), and one more vertex is (0, 0, 0, 0): the point at infinity.
class CasterBuffers {
 public:
  CasterBuffers();

  void UploadSurface(const ShadowCaster& caster);
  const SurfaceChunks& Surface() const { return surface_; }
  void UploadVolumes(const ShadowVolumes& volumes);

  // What of it can show in the clip volume.
  void DrawSurface(const glm::mat4& clip_from_position) const;
  void DrawCaps(const ShadowVolumes::Batch& batch) const;
  void DrawSides(const ShadowVolumes::Batch& batch) const;

 private:
  void DrawIndices(const GlObject& indices, std::size_t first, std::size_t count) const;

  GlObject vertex_array_;
  GlObject vertices_;
  GlObject surface_indices_;
  GlObject cap_indices_;
  GlObject side_indices_;
  SurfaceChunks surface_;
};

}  // namespace pleinair
