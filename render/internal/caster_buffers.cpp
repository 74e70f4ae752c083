#include "render/internal/caster_buffers.h"

#include <vector>

#include <glm/vec4.hpp>

#include "render/internal/draw_count.h"

namespace pleinair {

CasterBuffers::CasterBuffers()
    : vertex_array_(MakeVertexArray()),
      vertices_(MakeBuffer()),
      surface_indices_(MakeBuffer()),
      cap_indices_(MakeBuffer()),
      side_indices_(MakeBuffer()) {
  glBindVertexArray(vertex_array_.Name());
  glBindBuffer(GL_ARRAY_BUFFER, vertices_.Name());
  glEnableVertexAttribArray(0);
  glVertexAttribPointer(0, 4, GL_FLOAT, GL_FALSE, sizeof(glm::vec4), nullptr);
  glBindVertexArray(0);
}

void CasterBuffers::UploadSurface(const ShadowCaster& caster) {
  std::vector<glm::vec4> vertices;
  vertices.reserve(caster.Positions().size() + 1);
  for (const glm::vec3& position : caster.Positions()) vertices.emplace_back(position, 1.0f);
  vertices.emplace_back(0.0f);
  surface_ = SurfaceChunks(caster.Positions(), caster.Triangles());
  const std::vector<glm::uvec3> triangles(surface_.Triangles().begin(), surface_.Triangles().end());
  glBindVertexArray(vertex_array_.Name());
  UploadBuffer(vertices_, GL_ARRAY_BUFFER, vertices, GL_STATIC_DRAW);
  UploadBuffer(surface_indices_, GL_ELEMENT_ARRAY_BUFFER, triangles, GL_STATIC_DRAW);
  glBindVertexArray(0);
}

void CasterBuffers::UploadVolumes(const ShadowVolumes& volumes) {
  glBindVertexArray(vertex_array_.Name());
  UploadBuffer(cap_indices_, GL_ELEMENT_ARRAY_BUFFER, volumes.caps, GL_STREAM_DRAW);
  UploadBuffer(side_indices_, GL_ELEMENT_ARRAY_BUFFER, volumes.sides, GL_STREAM_DRAW);
  glBindVertexArray(0);
}

void CasterBuffers::DrawIndices(const GlObject& indices,
                                std::size_t first,
                                std::size_t count) const {
  if (count == 0) return;
  glBindVertexArray(vertex_array_.Name());
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices.Name());
  CountDraw();
  glDrawElements(
      GL_TRIANGLES,
      static_cast<GLsizei>(count),
      GL_UNSIGNED_INT,
      // An offset, which OpenGL takes as a pointer. NOLINTNEXTLINE(performance-no-int-to-ptr)
      reinterpret_cast<const void*>(first * sizeof(std::uint32_t)));
}

void CasterBuffers::DrawSurface(const glm::mat4& clip_from_position) const {
  // One by one: OpenGL ES has no call for several, but for an extension that some drivers lack.
  for (const auto& [first, count] : surface_.InView(clip_from_position)) {
    DrawIndices(surface_indices_, 3 * first, 3 * count);
  }
}

void CasterBuffers::DrawCaps(const ShadowVolumes::Batch& batch) const {
  DrawIndices(cap_indices_, batch.first_cap, batch.cap_count);
}

void CasterBuffers::DrawSides(const ShadowVolumes::Batch& batch) const {
  DrawIndices(side_indices_, batch.first_side, batch.side_count);
}

}  // namespace pleinair
