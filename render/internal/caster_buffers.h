// A caster on the device: its surface, for depth, and its shadow volumes.
#pragma once

#include "render/internal/gl_object.h"
#include "render/internal/shadow_caster.h"

namespace pleinair {

// Vertex attribute 0 is (position, 1), and one more vertex is (0, 0, 0, 0): the point at infinity.
class CasterBuffers {
 public:
  CasterBuffers();

  void UploadSurface(const ShadowCaster& caster);
  void UploadVolumes(const ShadowVolumes& volumes);

  void DrawSurface() const;
  void DrawCaps(const ShadowVolumes::Batch& batch) const;
  void DrawSides(const ShadowVolumes::Batch& batch) const;
  // Triangles of `indices`, a buffer of the caller's, over the caster's positions.
  void DrawTriangles(const GlObject& indices, std::size_t first, std::size_t count) const;

 private:
  void DrawIndices(const GlObject& indices, std::size_t first, std::size_t count) const;

  GlObject vertex_array_;
  GlObject vertices_;
  GlObject surface_indices_;
  GlObject cap_indices_;
  GlObject side_indices_;
  std::size_t surface_index_count_ = 0;
};

}  // namespace pleinair
